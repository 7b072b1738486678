// Numbers go to the ranks that own their rows; there they become blocks in the order of columns.
// SPDX-License-Identifier: BSD-3-Clause
#include "solver/delassus_matrix.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>

#include "solver/problem.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

/// Equal parts: rank r owns contacts [total r / size, total (r + 1) / size).
std::int64_t first_of(const Comm& comm, std::int64_t total, int rank) {
  return total * rank / comm.size;
}
int owner_of(const Comm& comm, std::int64_t total, std::int64_t contact) {
  return static_cast<int>(((contact + 1) * comm.size - 1) / total);
}

/// Every number at the rank of its row, sorted by blocks.
std::vector<MatrixEntry> at_their_owners(const Comm& comm, std::int64_t total,
                                         const std::vector<MatrixEntry>& entries) {
  ByRank<double> outgoing;
  for (const auto& [row, column, value] : entries) {
    auto& to = outgoing[owner_of(comm, total, row / 3)];
    to.insert(to.end(), {static_cast<double>(row), static_cast<double>(column), value});
  }
  std::vector<MatrixEntry> own;
  for (const auto& [rank, from] : comm.exchange(std::move(outgoing)))
    for (std::size_t k = 0; k < from.size(); k += 3)
      own.push_back({static_cast<std::int64_t>(from[k]), static_cast<std::int64_t>(from[k + 1]),
                     from[k + 2]});
  std::stable_sort(own.begin(), own.end(), [](const MatrixEntry& a, const MatrixEntry& b) {
    return std::pair(a.row / 3, a.column / 3) < std::pair(b.row / 3, b.column / 3);
  });
  return own;
}

/// x . W y over all ranks, for vectors that every rank makes up alike.
double product(const DelassusMatrix& matrix, const std::vector<Vec3>& x,
               const std::vector<Vec3>& y) {
  double sum = 0;
  for (Index c = 0; c < matrix.owned; ++c)
    for (auto k = matrix.start[c]; k < matrix.start[c + 1]; ++k)
      sum += x[c].dot(matrix.block[k] * y[matrix.column[k]]);
  return matrix.contacts.comm().sum(sum);
}

/// A symmetric W gives x . W y = y . W x; one that is not does so for no pair chosen at random.
void check_symmetry(const DelassusMatrix& matrix) {
  const std::size_t rows = static_cast<std::size_t>(matrix.owned) + matrix.contacts.ghosts();
  std::vector<Vec3> x(rows), y(rows);
  for (Index c = 0; c < matrix.owned; ++c)
    for (int d = 0; d < 3; ++d) {
      const double place = 3.0 * static_cast<double>(matrix.begin + c) + d;
      x[c][d] = std::sin(1 + 1.7 * place);
      y[c][d] = std::cos(2 + 2.3 * place);
    }
  matrix.contacts.gather(flat(x), 3);
  matrix.contacts.gather(flat(y), 3);
  const double difference = product(matrix, x, y) - product(matrix, y, x);
  double scale = 0;
  for (const Eigen::Matrix3d& block : matrix.block) scale += block.cwiseAbs().sum();
  require(std::abs(difference) <= 1e-9 * matrix.contacts.comm().sum(scale),
          "Delassus matrix is not symmetric");
}

/// See DelassusMatrix::outside.
void measure_outside(DelassusMatrix& matrix) {
  const std::size_t rows = static_cast<std::size_t>(matrix.owned) + matrix.contacts.ghosts();
  std::vector<Vec3> roots(rows);  // of S^-1
  const auto inverse_root = [](double a) { return a > 0 ? 1 / std::sqrt(a) : 0; };
  for (Index c = 0; c < matrix.owned; ++c)
    for (int d = 0; d < 3; ++d)
      roots[c][d] = inverse_root(d == 0 ? matrix.metric[c].a_n : matrix.metric[c].a_t);
  matrix.contacts.gather(flat(roots), 3);
  matrix.outside.assign(matrix.owned, 0);
  for (Index c = 0; c < matrix.owned; ++c)
    for (auto k = matrix.start[c]; k < matrix.start[c + 1]; ++k) {
      const Index d = matrix.column[k];
      if (d < matrix.owned) continue;
      matrix.outside[c] += (roots[c].asDiagonal() * matrix.block[k] * roots[d].asDiagonal()).norm();
    }
}

}  // namespace

ContactMetric bound_of(const Mat3& block, const Vec3& normal) {
  const Vec3 t1 = normal.unitOrthogonal(), t2 = normal.cross(t1);
  const Vec3 along = block * normal;
  const double nn = normal.dot(along), nt = (along - nn * normal).norm();
  const double a = t1.dot(block * t1), c = t2.dot(block * t2), ac = t1.dot(block * t2);
  const double b = (a + c) / 2 + std::sqrt((a - c) * (a - c) / 4 + ac * ac);
  if (nn <= 0 || b <= 0) return {};  // neither body ever moves
  const double rho = nt / std::sqrt(nn * b);
  return {(1 + rho) * nn, (1 + rho) * b};
}

Mat3 delassus_block(const ContactProblem& problem, Index c) {
  Mat3 block = Mat3::Zero();
  const auto add = [&](Index b, const Vec3& arm) {
    Mat3 cross;
    cross << 0, -arm.z(), arm.y(), arm.z(), 0, -arm.x(), -arm.y(), arm.x(), 0;
    block += problem.inverse_mass[b] * Mat3::Identity() - cross * problem.turning[b] * cross;
  };
  add(problem.i[c], problem.arm_i[c]);
  if (problem.j[c] != ground) add(problem.j[c], problem.arm_j[c]);
  return block;
}

ContactMetric bounding_metric(const Eigen::Matrix3d& block) {
  const double mean = (block(1, 1) + block(2, 2)) / 2;
  const double apart = std::hypot((block(1, 1) - block(2, 2)) / 2, block(1, 2));
  const Vec3 start(block(0, 0), mean + apart, mean + apart);
  const Vec3 scale = start.unaryExpr([](double a) { return a > 0 ? 1 / std::sqrt(a) : 0.0; });
  const Eigen::Matrix3d relative = scale.asDiagonal() * block * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> values(relative, Eigen::EigenvaluesOnly);
  const double factor = values.eigenvalues()[2];
  return {factor * start[0], factor * start[1]};
}

DelassusMatrix DelassusMatrix::assemble(const Comm& comm, std::int64_t contacts,
                                        const std::vector<MatrixEntry>& entries) {
  DelassusMatrix matrix;
  matrix.begin = first_of(comm, contacts, comm.rank);
  matrix.owned = static_cast<Index>(first_of(comm, contacts, comm.rank + 1) - matrix.begin);

  std::map<std::int64_t, Index> ghost;  // in the order of contacts
  const std::vector<MatrixEntry> own = at_their_owners(comm, contacts, entries);
  for (const MatrixEntry& entry : own) {
    const std::int64_t c = entry.column / 3;
    if (c < matrix.begin || c >= matrix.begin + matrix.owned) ghost[c] = 0;
  }
  std::vector<Origin> origins;
  for (auto& [contact, row] : ghost) {
    row = matrix.owned + static_cast<Index>(origins.size());
    const int rank = owner_of(comm, contacts, contact);
    origins.push_back({rank, static_cast<Index>(contact - first_of(comm, contacts, rank))});
  }
  matrix.contacts = Ghosts(comm, matrix.owned, origins);

  matrix.start.assign(matrix.owned + 1, 0);
  matrix.metric.resize(matrix.owned);
  std::vector<Eigen::Matrix3d> diagonal(matrix.owned, Eigen::Matrix3d::Zero());
  std::int64_t row = -1, column = -1;
  for (const MatrixEntry& entry : own) {
    if (entry.row / 3 != row || entry.column / 3 != column) {
      row = entry.row / 3;
      column = entry.column / 3;
      const auto found = ghost.find(column);
      matrix.column.push_back(found == ghost.end() ? static_cast<Index>(column - matrix.begin)
                                                   : found->second);
      matrix.block.push_back(Eigen::Matrix3d::Zero());
      ++matrix.start[row - matrix.begin + 1];
    }
    matrix.block.back()(entry.row % 3, entry.column % 3) += entry.value;
    if (row == column) diagonal[row - matrix.begin] = matrix.block.back();
  }
  bool negative = false;
  for (Index c = 0; c < matrix.owned; ++c) {
    matrix.start[c + 1] += matrix.start[c];
    matrix.metric[c] = bounding_metric(diagonal[c]);
    negative = negative || diagonal[c].diagonal().minCoeff() < 0;
  }
  require(!comm.any(negative), "Delassus matrix has negative numbers on its diagonal");
  check_symmetry(matrix);
  measure_outside(matrix);
  return matrix;
}

MatrixRows<double> pack(const DelassusMatrix& matrix, double unit) {
  MatrixRows<double> packed{&matrix.contacts, matrix.start, matrix.column, {}, matrix.outside};
  for (const Eigen::Matrix3d& block : matrix.block) {
    auto& to = packed.blocks.emplace_back();
    for (int d = 0; d < 3; ++d)
      to.column[d] = HalfOf<double>{block(0, d), block(1, d), block(2, d), 0} / unit;
  }
  return packed;
}

MatrixRows<float> round(const MatrixRows<double>& matrix) {
  MatrixRows<float> rounded{matrix.contacts, matrix.start, matrix.column, {}, matrix.outside};
  for (const auto& block : matrix.blocks) {
    auto& to = rounded.blocks.emplace_back();
    for (int d = 0; d < 3; ++d) to.column[d] = convert<float>(block.column[d]);
  }
  return rounded;
}

}  // namespace spall
