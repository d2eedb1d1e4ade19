// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "collision/cell_cover.h"
#include "engine/grasp/frame.h"
#include "engine/grasp/model.h"

namespace thenar {

/// Notes where the object has edges, for pulps whose cells they may cut.
void find_edges(Model& model);

/// Returns whether a cell of a pulp moving along the mean normal there sees the edges at a sample: not those of a spike
/// so slender that all of its faces lie along the way.
[[nodiscard]] bool has_edges_for_cells(const Model& model, Eigen::Index sample);

/// A cell of a pulp and the part of the object next to it.
struct EdgeCell {
  int finger = 0;
  Eigen::Index control_point = 0;
  Eigen::Vector3d p_O = Eigen::Vector3d::Zero();    ///< The control point at rest, object frame.
  Eigen::Vector3d N_O = Eigen::Vector3d::Zero();    ///< Normal out of the pulp there.
  Eigen::Vector3d u_O = Eigen::Vector3d::Zero();    ///< The pulp's deformation.
  Eigen::Vector3d way_O = Eigen::Vector3d::Zero();  ///< Its expected way against the object until the frame is used.
  Eigen::Index sample = 0;  ///< Sample of the face before it: ImplicitSurface::beside() has the others.
};

/// A face as a cell sees it.
struct FacePlane {
  Eigen::Vector3d n, point_m;
  int face = -1;  ///< Face of an object with exact faces.
};

/// Workspace of edge_contact().
struct EdgeWork {
  EdgeWork() : cells(ImplicitSurface::kMostBeside + 1) {
    faces.reserve(ImplicitSurface::kMostBeside + 1);
    planes.reserve(ImplicitSurface::kMostBeside + 1);
  }

  CellWork cells;
  std::vector<CellFace> faces;
  std::vector<FacePlane> planes;
};

enum class AtEdge { kWhole, kCut, kFree };

/// Computes the contact of a cell that an edge cuts. The interaction of pulp and object is an energy,
///     U = min over u of u' C^-1 u / 2   so that   N_i.u_i >= d_i,
/// where d_i is how deep the object reaches, in the mean, into that part of the cell i that it reaches into at all
/// (cell_cover), and the point's own compliance is that of such a part: k_ii / m, m about the root of its share, and
/// less where it is small or aside of the cell's middle. All are functions of the pose, so that no way leads to energy
/// that was not put in. The force is lambda_i grad d_i and, by the change of the compliance, lambda_i^2 k_ii grad m_i /
/// (2 m_i^2): it leans towards where more of the cell would be pressed. The pulp gives way along N, and is sheared
/// across it; what shears it is friction across grad d. Across what leans it would hold as glue does.
///
/// Cells stay where they are as the pulp is sheared: those that their lean shears off an edge would snap. Where a face
/// has the whole cell, its depth is that at the sheared point, as in all other contacts, and by less and less as edges
/// cut it.
///
/// A cell that is not reached yet, but may be while the frame is in use (`band_m`, with the finger's travel), has the
/// contact that it will have when it is in by that.
///
/// kWhole: no edge cuts it, `contact` is as it was, and `of.sample` is of the face that has it. kFree: nothing of it
/// is in the object or will be, or it is in too deep, or looks along all faces. `softness` is the frame's. Does not
/// allocate.
[[nodiscard]] AtEdge edge_contact(const Model& model, const Eigen::Isometry3d& X_OF, EdgeCell& of, double softness,
                                  double band_m, EdgeWork& work, FrameContact& contact);

}  // namespace thenar
