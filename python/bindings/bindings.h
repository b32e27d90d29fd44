#pragma once

#include <nanobind/nanobind.h>

// One function a folder of the library that Python sees; module.cpp calls them.

void bind_core(nanobind::module_& module);
void bind_cuda(nanobind::module_& module);
void bind_device(nanobind::module_& module);
void bind_device_memory(nanobind::module_& module);
void bind_double(nanobind::module_& module);
void bind_file(nanobind::module_& module);
void bind_hit_lists(nanobind::module_& module);
void bind_pipeline(nanobind::module_& module);
void bind_point_queries(nanobind::module_& module);
void bind_query(nanobind::module_& module);
void bind_surface(nanobind::module_& module);
