#include "bindings.h"

NB_MODULE(_core, module) {
  module.doc() = "treelet's compiled part; use the functions of the package treelet.";
  module.attr("__version__") = TREELET_VERSION;
  bind_core(module);
  bind_cuda(module);
  bind_pipeline(module);
  bind_device(module);  // its methods take and give classes of the pipeline
  bind_device_memory(module);
  bind_query(module);
  bind_point_queries(module);
  bind_hit_lists(module);
  bind_surface(module);
  bind_double(module);
  bind_file(module);
}
