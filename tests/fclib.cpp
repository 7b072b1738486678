// Problems given as a Delassus matrix: the file, the metric, and the same methods as for spheres.
// SPDX-License-Identifier: BSD-3-Clause
#include "output/fclib.hpp"

#include <Eigen/Dense>
#include <filesystem>

#include "../src/output/h5.hpp"
#include "contact_problems.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

constexpr SolverMethod all_methods[] = {SolverMethod::accelerated, SolverMethod::apgd,
                                        SolverMethod::barzilai_borwein, SolverMethod::sor};

/// What a file holds, the same on every rank.
struct Dense {
  Eigen::MatrixXd w;
  std::vector<double> q, mu;
};

enum class Storage { rows, columns, triplets };

/// The file's arrays, for tests to spoil.
struct Arrays {
  std::vector<std::int32_t> size, layout, pointers, indices, dimension{3};
  std::vector<double> values, q, mu, solution;
  std::string left_out;
};

Arrays arrays_of(const Dense& dense, Storage storage) {
  Arrays a;
  const auto n = static_cast<std::int32_t>(dense.w.rows());
  a.size = {n};
  a.q = dense.q;
  a.mu = dense.mu;
  if (storage != Storage::triplets) a.pointers.push_back(0);
  for (std::int32_t major = 0; major < n; ++major) {
    for (std::int32_t minor = 0; minor < n; ++minor) {
      const double value =
          storage == Storage::columns ? dense.w(minor, major) : dense.w(major, minor);
      if (value == 0) continue;
      // Triplets at one place add up.
      const int parts = storage == Storage::triplets ? 2 : 1;
      for (int part = 0; part < parts; ++part) {
        a.indices.push_back(minor);
        a.values.push_back(value / parts);
        if (storage == Storage::triplets) a.pointers.push_back(major);
      }
    }
    if (storage != Storage::triplets)
      a.pointers.push_back(static_cast<std::int32_t>(a.values.size()));
  }
  a.layout = {storage == Storage::rows      ? -2
              : storage == Storage::columns ? -1
                                            : static_cast<std::int32_t>(a.values.size())};
  return a;
}

/// Written by rank 0 alone; gone when the test is over.
class TemporaryFile {
 public:
  explicit TemporaryFile(const Arrays& a) {
    const Comm comm = testing_world();
    path_ = fmt::format("problem_of_{}.hdf5", comm.size);
    if (comm.rank == 0) {
      h5::File file = h5::File::create(path_);
      const auto write = [&](const std::string& name, const auto& values) {
        using T = typename std::remove_cvref_t<decltype(values)>::value_type;
        if (name != a.left_out) file.write<T>("/fclib_local/" + name, std::span<const T>(values));
      };
      write("spacedim", a.dimension);
      for (const char* name : {"W/m", "W/n"}) write(name, a.size);
      write("W/nz", a.layout);
      write("W/p", a.pointers);
      write("W/i", a.indices);
      write("W/x", a.values);
      write("vectors/q", a.q);
      write("vectors/mu", a.mu);
      if (!a.solution.empty())
        file.write<double>("/solution/r", std::span<const double>(a.solution));
      file.close();
    }
    comm.sum(0.0);
  }
  ~TemporaryFile() {
    testing_world().sum(0.0);
    if (testing_world().rank == 0) std::filesystem::remove(path_);
  }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

LocalProblem read(const Arrays& a) {
  return read_fclib(TemporaryFile(a).path(), testing_world());
}

/// Impulses of all contacts in the order of the file, on every rank.
Eigen::VectorXd collect(const LocalProblem& problem, const std::vector<Vec3>& impulse) {
  std::vector<double> own;
  for (const Vec3& p : impulse) own.insert(own.end(), p.data(), p.data() + 3);
  const auto all = problem.rows.comm().all_gather(std::span<const double>(own));
  return Eigen::Map<const Eigen::VectorXd>(all.data(), static_cast<Eigen::Index>(all.size()));
}

struct Answer {
  Eigen::VectorXd impulse;
  SolverReport report;
};

Answer solve_file(const Arrays& a, const SolverSettings& settings) {
  const LocalProblem problem = read(a);
  std::vector<Vec3> impulse(problem.q.size(), Vec3::Zero());
  const SolverReport report = solve(problem.view(), problem.rows, settings, impulse).report;
  return {collect(problem, impulse), report};
}

/// A frame (n, t1, t2) as rows.
Eigen::Matrix3d frame(const Vec3& n, double angle) {
  const Vec3 t =
      std::cos(angle) * n.unitOrthogonal() + std::sin(angle) * n.cross(n.unitOrthogonal());
  Eigen::Matrix3d rows;
  rows << n.transpose(), t.transpose(), n.cross(t).transpose();
  return rows;
}

/// The explicit matrix of a problem of spheres, each contact in a frame of its own.
Dense explicit_matrix(const WholeProblem& whole, std::vector<Eigen::Matrix3d>& frames) {
  const Index n = whole.contacts();
  Dense dense{Eigen::MatrixXd::Zero(3 * n, 3 * n), std::vector<double>(3 * n), whole.friction};
  for (Index c = 0; c < n; ++c) frames.push_back(frame(whole.normal[c], c));
  for (Index c = 0; c < n; ++c) {
    Eigen::Map<Vec3>(&dense.q[3 * c]) = frames[c] * whole.free_velocity[c];
    for (Index e = 0; e < n; ++e)
      dense.w.block<3, 3>(3 * c, 3 * e) =
          frames[c] * delassus_block(whole, c, e) * frames[e].transpose();
  }
  return dense;
}

/// Contacts with full 3x3 blocks, normal and tangents coupled, the matrix well conditioned.
Dense random_problem(int contacts) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const int n = 3 * contacts;
  const auto draw = [&] { return uniform(random); };
  const Eigen::MatrixXd root = Eigen::MatrixXd::NullaryExpr(n, n, draw);
  Dense dense;
  dense.w = root.lazyProduct(root.transpose()) / n + 0.2 * Eigen::MatrixXd::Identity(n, n);
  dense.w = ((dense.w + dense.w.transpose()) / 2).eval();
  for (int k = 0; k < n; ++k) dense.q.push_back(draw() - (k % 3 == 0 ? 0.5 : 0));
  for (int c = 0; c < contacts; ++c) dense.mu.push_back(0.5 * std::abs(draw()));
  return dense;
}

Eigen::VectorXd velocity(const Dense& dense, const Eigen::VectorXd& p) {
  return dense.w.lazyProduct(p) + Eigen::Map<const Eigen::VectorXd>(dense.q.data(), p.size());
}

TEST(Metric, bounds_the_block_as_tightly_as_its_shape_allows) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int sample = 0; sample < 100; ++sample) {
    const Eigen::Matrix3d root = Eigen::Matrix3d::NullaryExpr([&] { return uniform(random); });
    const Eigen::Matrix3d block = root * root.transpose();
    const ContactMetric s = bounding_metric(block);
    const Eigen::Matrix3d rest = Vec3(s.a_n, s.a_t, s.a_t).asDiagonal().toDenseMatrix() - block;
    const double least = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(rest).eigenvalues()[0];
    EXPECT_NEAR(least, 0, 1e-14 * block.norm() * 10);  // below: a bound; above: not the smallest
    EXPECT_LE(s.a_n, 2 * block(0, 0) * (1 + 1e-14));
  }
  const ContactMetric sphere = bounding_metric(Vec3(2, 7, 7).asDiagonal());
  EXPECT_NEAR(sphere.a_n, 2, 1e-14);
  EXPECT_NEAR(sphere.a_t, 7, 1e-14);
  EXPECT_EQ(bounding_metric(Eigen::Matrix3d::Zero()).a_n, 0);
}

TEST(File, gives_the_matrix_in_every_storage) {
  const Dense dense = random_problem(7);
  for (Storage storage : {Storage::rows, Storage::columns, Storage::triplets}) {
    const LocalProblem problem = read(arrays_of(dense, storage));
    EXPECT_EQ(problem.contacts, 7);
    std::vector<double> place(problem.matrix.owned + problem.matrix.contacts.ghosts());
    for (Index c = 0; c < problem.matrix.owned; ++c) place[c] = problem.matrix.begin + c;
    problem.matrix.contacts.gather(place.data(), 1);
    for (Index c = 0; c < problem.matrix.owned; ++c) {
      EXPECT_EQ(problem.matrix.start[c + 1] - problem.matrix.start[c], 7);
      EXPECT_EQ(problem.mu[c], dense.mu[problem.matrix.begin + c]);
      for (auto k = problem.matrix.start[c]; k < problem.matrix.start[c + 1]; ++k) {
        const auto other = static_cast<Index>(place[problem.matrix.column[k]]);
        EXPECT_EQ(problem.matrix.block[k],
                  (dense.w.block<3, 3>(3 * (problem.matrix.begin + c), 3 * other)));
      }
    }
  }
}

TEST(Matrix, gives_the_impulses_that_spheres_give) {
  const Comm comm = testing_world();
  const WholeProblem whole = shaken_block(3, 0.4, 0);
  std::vector<Eigen::Matrix3d> frames;
  const Dense dense = explicit_matrix(whole, frames);
  const Arrays arrays = arrays_of(dense, Storage::rows);
  for (FrictionModel friction : {FrictionModel::convex, FrictionModel::coulomb})
    for (SolverMethod method : all_methods) {
      const bool minimises =
          method == SolverMethod::apgd || method == SolverMethod::barzilai_borwein;
      if (minimises && friction == FrictionModel::coulomb) continue;
      const SolverSettings settings{.method = method,
                                    .friction = friction,
                                    .tolerance = 1e-7,
                                    .max_iterations = 100000,
                                    .prox = 0};
      const Answer answer = solve_file(arrays, settings);
      EXPECT_TRUE(answer.report.converged) << static_cast<int>(method);
      const Solved spheres = solve_whole(whole, settings, random_owners(whole.bodies(), comm.size));
      Eigen::VectorXd expected(answer.impulse.size());
      for (Index c = 0; c < whole.contacts(); ++c)
        expected.segment<3>(3 * c) = frames[c] * spheres.impulse[c];
      // Velocities are unique. Impulses need not be; those of `accelerated` take the same way.
      EXPECT_LT((velocity(dense, answer.impulse) - velocity(dense, expected)).norm(), 1e-5);
      if (method == SolverMethod::accelerated) {
        EXPECT_LT((answer.impulse - expected).cwiseAbs().maxCoeff(), 1e-4);
      }
    }
}

TEST(Matrix, with_full_blocks_is_solved_to_coulombs_law) {
  const Dense dense = random_problem(12);
  for (SolverMethod method : {SolverMethod::accelerated, SolverMethod::sor}) {
    const Answer answer =
        solve_file(arrays_of(dense, Storage::columns),
                   {.method = method, .tolerance = 1e-10, .max_iterations = 100000, .prox = 0});
    EXPECT_TRUE(answer.report.converged);
    const Eigen::VectorXd u = velocity(dense, answer.impulse);
    int sliding = 0, sticking = 0, open = 0;
    for (int c = 0; c < 12; ++c) {
      const double p_n = answer.impulse[3 * c], u_n = u[3 * c];
      const Eigen::Vector2d p_t = answer.impulse.segment<2>(3 * c + 1);
      const Eigen::Vector2d u_t = u.segment<2>(3 * c + 1);
      EXPECT_GE(p_n, 0);
      EXPECT_GE(u_n, -1e-9);
      EXPECT_NEAR(p_n * u_n, 0, 1e-9);
      EXPECT_LE(p_t.norm(), dense.mu[c] * p_n + 1e-9);
      EXPECT_NEAR(p_t.dot(u_t), -dense.mu[c] * p_n * u_t.norm(), 1e-9);
      ++(p_n == 0 ? open : u_t.norm() > 1e-6 ? sliding : sticking);
    }
    EXPECT_GT(sliding, 0);
    EXPECT_GT(open, 0);
    EXPECT_EQ(open + sliding + sticking, 12);
  }
}

TEST(Matrix, with_full_blocks_has_one_convex_solution_for_all_methods) {
  const Dense dense = random_problem(12);
  std::vector<Answer> answers;
  for (SolverMethod method : all_methods) {
    answers.push_back(
        solve_file(arrays_of(dense, Storage::rows), {.method = method,
                                                     .friction = FrictionModel::convex,
                                                     .tolerance = 1e-6,
                                                     .max_iterations = 20000,
                                                     .prox = 0}));
    EXPECT_TRUE(answers.back().report.converged) << static_cast<int>(method);
    EXPECT_LT((answers.back().impulse - answers[0].impulse).cwiseAbs().maxCoeff(), 1e-5);
  }
}

TEST(Evaluation, finds_the_residual_that_a_solve_reports) {
  const Dense dense = random_problem(12);
  Arrays arrays = arrays_of(dense, Storage::rows);
  for (FrictionModel friction : {FrictionModel::convex, FrictionModel::coulomb}) {
    const Answer answer = solve_file(arrays, {.friction = friction, .tolerance = 1e-2, .prox = 0});
    arrays.solution.assign(answer.impulse.begin(), answer.impulse.end());
    const LocalProblem problem = read(arrays);
    const SolverReport report = evaluate(problem.view(), problem.rows, friction, problem.solution);
    EXPECT_NEAR(report.residual, answer.report.residual, 1e-10);
    EXPECT_NEAR(report.residual_max, answer.report.residual_max, 1e-10);
    const std::vector<Vec3> none(problem.q.size(), Vec3::Zero());
    EXPECT_EQ(evaluate(problem.view(), problem.rows, friction, none).residual, 1);
  }
}

/// The message of the error that the arrays lead to.
std::string complaint(const Arrays& a) {
  return complaint_of([&] { read(a); });
}

TEST(File, that_cannot_be_right_is_refused_by_name) {
  const Arrays good = arrays_of(random_problem(5), Storage::rows);
  const auto expect = [&](const char* words, auto&& spoil) {
    Arrays bad = good;
    spoil(bad);
    EXPECT_NE(complaint(bad).find(words), std::string::npos) << words << "\n" << complaint(bad);
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(complaint(good), "");
  for (const char* name : {"W/x", "W/i", "W/p", "W/nz", "vectors/q", "vectors/mu", "spacedim"})
    expect(name, [&](Arrays& a) { a.left_out = name; });
  expect("W/x holds numbers that are not finite", [&](Arrays& a) { a.values[40] = nan; });
  expect("vectors/q holds numbers that are not finite", [&](Arrays& a) { a.q[13] = infinity; });
  expect("vectors/mu holds numbers that are not finite", [&](Arrays& a) { a.mu[4] = nan; });
  expect("solution/r holds numbers that are not finite",
         [&](Arrays& a) { a.solution.assign(15, nan); });
  expect("negative friction", [](Arrays& a) { a.mu[0] = -0.1; });
  expect("not symmetric", [](Arrays& a) { a.values[7] += 0.5; });
  expect("negative numbers on its diagonal", [](Arrays& a) { a.values[16] = -1; });
  expect("points outside", [](Arrays& a) { a.indices[100] = 15; });
  expect("pointers", [](Arrays& a) { a.pointers[3] = 0; });
  expect("nz is -3", [](Arrays& a) { a.layout = {-3}; });
  expect("spacedim is 2", [](Arrays& a) { a.dimension = {2}; });
  expect("15 x 15", [](Arrays& a) { a.mu.push_back(0.3); });
  expect("vectors/q", [](Arrays& a) { a.q.pop_back(); });
  EXPECT_THROW(read_fclib("no_such_file.hdf5", testing_world()), Error);
}

}  // namespace
}  // namespace spall
