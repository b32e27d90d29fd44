#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>

#include <treelet/pipeline/bvh.h>

/// A report under the names that treelet.Report gives its fields.
inline nanobind::dict describe_report(const treelet::BuildReport& report) {
  namespace nb = nanobind;
  nb::list stages;
  for (const treelet::StageTime& stage : report.stages) {
    stages.append(nb::make_tuple(stage.name, stage.seconds));
  }
  nb::dict leaf_histogram;
  for (std::size_t size = 1; size < report.tree.leaf_histogram.size(); ++size) {
    if (report.tree.leaf_histogram[size] == 0) continue;
    leaf_histogram[nb::int_(size)] = report.tree.leaf_histogram[size];
  }
  nb::dict result;
  result["recipe"] = report.recipe;
  result["stages"] = stages;
  result["build_seconds"] = report.seconds;
  result["faces"] = report.faces;
  result["references"] = report.references;
  result["left_out_non_finite"] = report.left_out_non_finite;
  result["left_out_degenerate"] = report.left_out_degenerate;
  result["nodes"] = report.tree.nodes;
  result["leaves"] = report.tree.leaves;
  result["depth"] = report.tree.depth;
  result["leaf_histogram"] = leaf_histogram;
  result["bytes"] = report.tree.bytes;
  result["sah"] = report.sah;
  result["layout_sah"] = report.update.refits > 0 ? report.update.sah : report.tree.sah;
  result["layout_sah_at_build"] = report.tree.sah;
  result["refits"] = report.update.refits;
  result["refit_seconds"] = report.update.seconds;
  result["hidden"] = report.update.hidden;
  result["held_bytes"] = report.update.held_bytes;
  return result;
}
