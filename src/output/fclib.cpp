// Each rank reads an equal part of every array; W's numbers then go to the owners of their rows.
// SPDX-License-Identifier: BSD-3-Clause
#include "output/fclib.hpp"

#include <algorithm>
#include <cmath>

#include "output/h5.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

constexpr std::int64_t compressed_columns = -1, compressed_rows = -2;  // else triplets

/// A dataset's rows, every number checked. Collective.
template <class T>
std::vector<T> read_finite(const h5::File& file, const std::string& path, const std::string& name,
                           const h5::Rows& rows, const Comm& comm) {
  const auto values =
      file.read<double>(name, {rows.begin * h5::Layout<T>::width, rows.count * h5::Layout<T>::width,
                               rows.total * h5::Layout<T>::width});
  const bool bad =
      !std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
  require(!comm.any(bad), "{}: {} holds numbers that are not finite", path, name);
  std::vector<T> result(rows.count);
  std::copy(values.begin(), values.end(), reinterpret_cast<double*>(result.data()));
  return result;
}

std::int64_t read_one(const h5::File& file, const std::string& path, const std::string& name) {
  const auto values = file.read<std::int32_t>(name);
  require(values.size() == 1, "{}: {} holds {} numbers, not one", path, name, values.size());
  return values[0];
}

/// This rank's share of W's numbers.
std::vector<MatrixEntry> read_entries(const h5::File& file, const std::string& path,
                                      std::int64_t contacts, const Comm& comm) {
  const std::string at = "/fclib_local/W/";
  const std::int64_t m = read_one(file, path, at + "m"), n = read_one(file, path, at + "n");
  require(m == 3 * contacts && n == m, "{}: {} is {} x {}, but there are {} friction coefficients",
          path, at, m, n, contacts);
  const std::int64_t layout = read_one(file, path, at + "nz");
  const bool triplets = layout >= 0;
  require(triplets || layout == compressed_columns || layout == compressed_rows,
          "{}: {}nz is {}, must be -2 (compressed rows), -1 (columns) or a number of triplets",
          path, at, layout);
  std::vector<std::int32_t> pointers;
  if (!triplets) {
    pointers = file.read<std::int32_t>(at + "p");
    require(static_cast<std::int64_t>(pointers.size()) == m + 1 && pointers[0] == 0 &&
                std::is_sorted(pointers.begin(), pointers.end()),
            "{}: {}p must hold {} pointers that begin at 0 and never fall", path, at, m + 1);
  }
  const std::int64_t used = triplets ? layout : pointers.back();
  const auto stored = static_cast<std::int64_t>(file.total_rows(at + "x"));
  require(used <= stored && file.total_rows(at + "i") == file.total_rows(at + "x"),
          "{}: {}x and {}i hold {} and {} numbers, {} are needed", path, at, at, stored,
          file.total_rows(at + "i"), used);

  const h5::Rows rows = h5::equal_rows(comm.rank, comm.size, stored);
  const auto values = read_finite<double>(file, path, at + "x", rows, comm);
  const auto minor = file.read<std::int32_t>(at + "i", rows);
  if (triplets) pointers = file.read<std::int32_t>(at + "p", rows);
  std::vector<MatrixEntry> entries;
  bool outside = false;
  for (std::size_t k = 0; k < values.size(); ++k) {
    const auto place = static_cast<std::int64_t>(rows.begin + k);
    if (place >= used) break;
    const std::int64_t major =
        triplets ? pointers[k]
                 : std::upper_bound(pointers.begin(), pointers.end(), place) - pointers.begin() - 1;
    outside = outside || minor[k] < 0 || minor[k] >= m || major < 0 || major >= m;
    entries.push_back({major, minor[k], values[k]});
  }
  require(!comm.any(outside), "{}: {}i or {}p points outside the matrix's {} rows", path, at, at,
          m);
  return entries;
}

}  // namespace

ContactProblem LocalProblem::view() const {
  return {.dimension = 3,
          .boundary = 0,
          .inverse_mass = zero_,
          .i = index_,
          .j = ground_,
          .normal = normal_,
          .kappa = zero_,
          .free_velocity = q,
          .friction = mu,
          .cohesive_impulse = zero_,
          .matrix = &matrix};
}

LocalProblem read_fclib(const std::string& path, const Comm& comm) {
  const h5::File file = h5::File::open(path, comm);
  const std::string at = "/fclib_local";
  require(file.exists(at), "{} has no group {}: only FCLIB's local problems can be solved", path,
          at);
  for (const char* constraint : {"/V", "/R"})
    require(!file.exists(at + constraint), "{}: bilateral constraints ({}{}) are not supported",
            path, at, constraint);
  const std::int64_t dimension = read_one(file, path, at + "/spacedim");
  require(dimension == 3, "{}: {}/spacedim is {}, must be 3", path, at, dimension);

  LocalProblem problem;
  if (file.exists(at + "/info/title")) problem.title = file.read_text(at + "/info/title");
  problem.contacts = static_cast<std::int64_t>(file.total_rows(at + "/vectors/mu"));
  require(problem.contacts >= comm.size, "{} has {} contacts for {} ranks", path, problem.contacts,
          comm.size);
  problem.matrix = DelassusMatrix::assemble(comm, problem.contacts,
                                            read_entries(file, path, problem.contacts, comm));
  const h5::Rows own = h5::equal_rows(comm.rank, comm.size, problem.contacts);
  problem.mu = read_finite<double>(file, path, at + "/vectors/mu", own, comm);
  problem.q = read_finite<Vec3>(file, path, at + "/vectors/q", own, comm);
  if (file.exists("/solution/r"))
    problem.solution = read_finite<Vec3>(file, path, "/solution/r", own, comm);
  const bool negative =
      std::any_of(problem.mu.begin(), problem.mu.end(), [](double mu) { return mu < 0; });
  require(!comm.any(negative), "{}: {}/vectors/mu holds negative friction coefficients", path, at);
  problem.rows = Ghosts(comm, problem.matrix.owned, {});
  problem.zero_.assign(own.count, 0);
  problem.ground_.assign(own.count, ground);
  problem.normal_.assign(own.count, Vec3::UnitX());
  for (Index c = 0; c < problem.matrix.owned; ++c) problem.index_.push_back(c);
  return problem;
}

}  // namespace spall
