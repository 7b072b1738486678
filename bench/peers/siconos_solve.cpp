// Solves one local frictional-contact problem with Siconos (Debian package siconos, 4.4).
// SPDX-License-Identifier: BSD-3-Clause
// usage: siconos_solve problem.bin METHOD TOLERANCE MAX_ITERATIONS solution.bin
// problem.bin: contacts and numbers of W (int64), rows, columns (int32), values, q, mu (double).
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>

extern "C" {
#include <siconos/numerics/FrictionContactProblem.h>
#include <siconos/numerics/Friction_cst.h>
#include <siconos/numerics/NonSmoothDrivers.h>
#include <siconos/numerics/NumericsMatrix.h>
#include <siconos/numerics/NumericsSparseMatrix.h>
#include <siconos/numerics/SiconosNumerics.h>
#include <siconos/numerics/SolverOptions.h>
#include <siconos/numerics/SparseBlockMatrix.h>
}

namespace {

template <class T>
std::vector<T> read(FILE* file, std::size_t count) {
  std::vector<T> values(count);
  if (std::fread(values.data(), sizeof(T), count, file) != count) std::exit(3);
  return values;
}

struct Method {
  const char* name;
  int id;
  bool blocks;  // wants W in 3x3 blocks
};
const Method methods[] = {
    {"NSGS", SICONOS_FRICTION_3D_NSGS, true},
    {"ADMM", SICONOS_FRICTION_3D_ADMM, false},
    {"NSN_AC", SICONOS_FRICTION_3D_NSN_AC, false},
    {"VI_EG", SICONOS_FRICTION_3D_VI_EG, false},
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 6) return 2;
  FILE* in = std::fopen(argv[1], "rb");
  if (!in) return 3;
  const auto size = read<long>(in, 2);
  const int contacts = static_cast<int>(size[0]);
  const auto row = read<int>(in, size[1]), column = read<int>(in, size[1]);
  const auto value = read<double>(in, size[1]);
  auto q = read<double>(in, 3 * contacts), mu = read<double>(in, contacts);

  const Method* method = nullptr;
  for (const Method& each : methods)
    if (!std::strcmp(argv[2], each.name)) method = &each;
  if (!method) return 2;

  NumericsMatrix* w = NM_create(NM_SPARSE, 3 * contacts, 3 * contacts);
  NM_triplet_alloc(w, value.size());
  for (std::size_t k = 0; k < value.size(); ++k) NM_entry(w, row[k], column[k], value[k]);
  if (method->blocks) {
    NumericsMatrix* blocks = NM_create(NM_SPARSE_BLOCK, 3 * contacts, 3 * contacts);
    if (!blocks->matrix1) blocks->matrix1 = SBM_new();
    SBM_from_csparse(3, NM_csc(w), blocks->matrix1);
    w = blocks;
  }
  FrictionContactProblem* problem =
      frictionContactProblem_new_with_data(3, contacts, w, q.data(), mu.data());
  SolverOptions* options = solver_options_create(method->id);
  options->dparam[SICONOS_DPARAM_TOL] = std::atof(argv[3]);
  options->iparam[SICONOS_IPARAM_MAX_ITER] = std::atoi(argv[4]);

  std::vector<double> r(3 * contacts, 0), u(3 * contacts, 0);
  const auto start = std::chrono::steady_clock::now();
  fc3d_driver(problem, r.data(), u.data(), options);
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  std::printf("seconds %.6f iterations %d\n", seconds, options->iparam[SICONOS_IPARAM_ITER_DONE]);
  FILE* out = std::fopen(argv[5], "wb");
  std::fwrite(r.data(), sizeof(double), r.size(), out);
  std::fclose(out);
}
