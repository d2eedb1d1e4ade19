# SPDX-License-Identifier: Apache-2.0
"""No function that a tick calls comes from a room that is optimised less.

An inline function, or one made from a template, is in every object that uses it and does not inline it, and the linker
keeps the first: one copy of the program's for all. So the rooms that ticks run in and those that are optimised less may
share no such function of ours or Eigen's. What is shared and harmless: constructors and destructors, which allocate,
and what else allocates or only throws, which no tick does.
"""
import argparse
import re
import shutil
import subprocess
import sys

HARMLESS = re.compile(
    # Copies of matrices, in which nothing is computed; sizes of blocks; what ends a memory's life.
    r"call_dense_assignment_loop<Eigen::Matrix<double, (?:-1|3), -?1, 0, (?:-1|3), -?1>, "
    r"Eigen::Matrix<double, (?:-1|3), -?1, 0, (?:-1|3), -?1>, "
    r"Eigen::internal::assign_op|DenseStorage<double, -1, -?1, -?1, 0>::DenseStorage\(|evaluateProductBlockingSizesHeuristic|aligned_malloc|>::~(?:gemm_blocking_space|runtime_sized_ringbuffer)\("
    r"|"
    # Products of run-time size, of which the analysis of the sampled pose loop consists; ticks have lazy products.
    r"general_matrix_vector_product<long, double, Eigen::internal::const_blas_data_mapper<double, long, 1>, 1, false|"
    r"throw_std_bad_alloc|conditional_aligned_new|PlainObjectBase<.*>::resize\(|Watcher::see_control"
    r"|^(decltype\(auto\) )?[^(<]*\bstd::|::(\w+)::~?\2(\[abi:\w+\])?\("
)


def shared_names(files):
    """Names of functions that more than one object may define."""
    text = subprocess.run(["nm", "-C", *files], capture_output=True, text=True, check=True).stdout
    return {line[19:] for line in text.splitlines() if line[17:18] == "W"}


parser = argparse.ArgumentParser()
parser.add_argument("--hot", nargs="+", required=True)
parser.add_argument("--cold", nargs="+", required=True)
files = parser.parse_args()
if not shutil.which("nm"):
    print("no nm here")
    sys.exit(77)
hot, cold = shared_names(files.hot), shared_names(files.cold)
if len(hot) < 50 or len(cold) < 50:
    sys.exit(f"nm tells of {len(hot)} and {len(cold)} functions alone: they are not what was built")
found = sorted(name for name in hot & cold if re.search(r"\b(thenar|Eigen)::", name) and not HARMLESS.search(name))
for name in found:
    print(f"in a room that is optimised less, too: {name}")
sys.exit(1 if found else 0)
