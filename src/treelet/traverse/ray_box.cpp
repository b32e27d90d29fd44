#include <treelet/traverse/ray_box.h>

#include <treelet/traverse/ray_box_steps.h>

namespace treelet {

RayBox::RayBox(const Ray& ray, const Aabb& scene) { ray_box_steps::set_up(*this, ray, scene); }

}  // namespace treelet
