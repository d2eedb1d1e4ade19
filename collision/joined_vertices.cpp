// SPDX-License-Identifier: Apache-2.0
#include "collision/joined_vertices.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <tuple>

#include "collision/mesh_edges.h"

namespace thenar {
namespace {

/// A vertex in a cell of the grid.
struct Placed {
  std::array<std::int64_t, 3> cell;
  int vertex;
  auto key() const { return std::tie(cell[0], cell[1], cell[2], vertex); }
};

/// Joins the vertices of each cell with those of the cells around it. Cells are as wide as vertices may be apart: two
/// that are nearer lie in one or in two that touch. Of the 26 cells around one, 13 follow it in the order of cells.
void join_cells(const std::vector<Placed>& placed, NumberSets& sets) {
  constexpr std::array<std::array<int, 2>, 5> kColumns = {{{0, 0}, {0, 1}, {1, -1}, {1, 0}, {1, 1}}};
  for (std::size_t i = 1; i < placed.size(); ++i) {
    if (placed[i].cell == placed[i - 1].cell) sets.join(placed[i].vertex, placed[i - 1].vertex);
  }
  for (const auto& [x, y] : kColumns) {
    // The cells that follow move on with the cell itself.
    std::size_t next = 0;
    for (std::size_t i = 0; i < placed.size(); ++i) {
      const Placed& at = placed[i];
      if (i > 0 && at.cell == placed[i - 1].cell) continue;  // It is joined with the first of its cell.
      const std::array<std::int64_t, 3> from = {at.cell[0] + x, at.cell[1] + y,
                                                at.cell[2] + (x == 0 && y == 0 ? 1 : -1)};
      while (next < placed.size() && placed[next].cell < from) ++next;
      for (std::size_t k = next; k < placed.size(); ++k) {
        const auto& cell = placed[k].cell;
        if (cell[0] != from[0] || cell[1] != from[1] || cell[2] > at.cell[2] + 1) break;
        sets.join(at.vertex, placed[k].vertex);
        // The others of this cell are joined with it: on to the next one, of which there are two at most.
        while (k + 1 < placed.size() && placed[k + 1].cell == cell) ++k;
      }
    }
  }
}

}  // namespace

std::vector<int> join_vertices(const Eigen::Matrix3Xd& vertices_m, double apart_m) {
  const auto count = static_cast<int>(vertices_m.cols());
  NumberSets sets(count);
  std::vector<int> joined(count);
  const double most = count == 0 ? 0.0 : vertices_m.cwiseAbs().maxCoeff();
  if (!(apart_m > 0.0) || !(most < 1e18 * apart_m)) {
    std::vector<int> order(joined.size());
    std::iota(order.begin(), order.end(), 0);
    const auto place = [&](int i) { return std::make_tuple(vertices_m(0, i), vertices_m(1, i), vertices_m(2, i)); };
    std::ranges::sort(order, {}, [&](int i) { return std::make_tuple(place(i), i); });
    for (std::size_t k = 1; k < order.size(); ++k) {
      if (place(order[k]) == place(order[k - 1])) sets.join(order[k], order[k - 1]);
    }
  } else {
    std::vector<Placed> placed(joined.size());
    for (int i = 0; i < count; ++i) {
      placed[i].vertex = i;
      for (int axis = 0; axis < 3; ++axis) {
        placed[i].cell[axis] = static_cast<std::int64_t>(std::floor(vertices_m(axis, i) / apart_m));
      }
    }
    std::ranges::sort(placed, {}, &Placed::key);
    join_cells(placed, sets);
  }
  for (int i = 0; i < count; ++i) joined[i] = sets.of(i);
  return joined;
}

}  // namespace thenar
