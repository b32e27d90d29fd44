#include <treelet/pipeline/suggest.h>

#include <algorithm>
#include <numeric>
#include <vector>

namespace treelet {
namespace {

/// Insertions, deletions and exchanges that turn one word into the other [Levenshtein1966].
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), 0);
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0]++;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] != b[j]);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, diagonal + 1});
    }
  }
  return row.back();
}

}  // namespace

std::string suggest(std::string_view unknown, std::span<const std::string_view> known) {
  if (known.empty()) return "; there are none";
  const auto closest = std::ranges::min_element(
      known, {}, [&](std::string_view name) { return edit_distance(unknown, name); });
  const bool is_close = edit_distance(unknown, *closest) <= 1 + closest->size() / 3;
  std::string text = is_close ? "; did you mean '" + std::string(*closest) + "'? There are: "
                              : std::string("; there are: ");
  for (const std::string_view& name : known) {
    if (&name != &known.front()) text += ", ";
    text += name;
  }
  return text;
}

}  // namespace treelet
