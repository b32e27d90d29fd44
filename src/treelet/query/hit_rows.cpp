#include <treelet/query/hit_rows.h>

#include <algorithm>

namespace treelet {
namespace {

constexpr std::size_t kFew = 24;  // of which sorting by insertion is the fastest

template <class Item, class Less>
void sort(std::span<Item> row, Less&& less) {
  if (row.size() > kFew) return std::sort(row.begin(), row.end(), less);
  for (std::size_t i = 1; i < row.size(); ++i) {
    const Item item = row[i];
    std::size_t place = i;
    for (; place != 0 && less(item, row[place - 1]); --place) row[place] = row[place - 1];
    row[place] = item;
  }
}

}  // namespace

std::size_t sort_row(std::span<Hit> row) {
  sort(row,
       [](const Hit& a, const Hit& b) { return a.t < b.t || (a.t == b.t && a.face < b.face); });
  const auto same = [](const Hit& a, const Hit& b) { return a.face == b.face; };
  return std::size_t(std::unique(row.begin(), row.end(), same) - row.begin());
}

std::size_t sort_row(std::span<std::int32_t> row) {
  sort(row, [](std::int32_t a, std::int32_t b) { return a < b; });
  return std::size_t(std::unique(row.begin(), row.end()) - row.begin());
}

}  // namespace treelet
