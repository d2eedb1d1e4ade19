// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "thenar/eigen_layout.h"

namespace thenar {

/// Rotates the rows of A until they are orthogonal, by one-sided Jacobi rotations [Hestenes 1958]: with U' orthogonal,
/// U' A = S V', whose rows have the singular values as lengths. Small values are as accurate as large ones. For checks
/// of small problems: plain loops, which compile in no time.
///
/// Shapes    A m x n; U m x m.
/// A         Out: S V', rows in no order; a row that depends on others is about zero.
/// U         Out: U, whose column i belongs to row i.
/// Cost      about 10 m^2 n multiply-adds. Does not allocate or throw.
void orthogonalize_rows(Eigen::Ref<Eigen::MatrixXd> A, Eigen::Ref<Eigen::MatrixXd> U) noexcept;

}  // namespace thenar
