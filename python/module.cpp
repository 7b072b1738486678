// The Python module spall._spall: the library's API with bodies as NumPy arrays.
// python/spall/__init__.py wraps it. SPDX-License-Identifier: BSD-3-Clause
#include <pybind11/functional.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <optional>
#include <set>

#include "base/kernels.hpp"
#include "run/run.hpp"
#include "spall/spall.hpp"

namespace py = pybind11;
using namespace py::literals;

namespace {

using namespace spall;

std::optional<Session>& session() {
  static std::optional<Session> the_session;
  return the_session;
}

/// Begins MPI where the program, such as mpi4py, has not.
Comm world() {
  if (!session()) session().emplace();
  return session()->world();
}

/// A simulation that can end before its Python object does: before MPI ends at the latest.
class Running {
 public:
  explicit Running(const Scene& scene) : simulation_(std::in_place, world(), scene) {
    all().insert(this);
  }
  Running(const Running&) = delete;
  Running& operator=(const Running&) = delete;
  ~Running() { all().erase(this); }

  Simulation& get() {
    if (!simulation_) throw Error("the simulation has ended with MPI");
    return *simulation_;
  }
  static void end_all() {
    for (Running* one : all()) one->simulation_.reset();
    session().reset();
  }

 private:
  static std::set<Running*>& all() {
    static std::set<Running*> alive;
    return alive;
  }
  std::optional<Simulation> simulation_;
};

template <class T>
constexpr py::ssize_t columns = 1;
template <>
constexpr py::ssize_t columns<Vec3> = 3;
template <>
constexpr py::ssize_t columns<Quaternion> = 4;

/// A view of the first `rows` rows, of which `owner` keeps the memory; to be written where asked.
template <class T>
py::array view(const T* data, py::ssize_t rows, py::handle owner, bool writable) {
  py::array array;
  if constexpr (columns < T >> 1)
    array = py::array_t<double>({rows, columns<T>}, reinterpret_cast<const double*>(data), owner);
  else
    array = py::array_t<T>({rows}, data, owner);
  // As array.setflags(write=False) does, which takes longer than all the rest of this.
  if (!writable)
    py::detail::array_proxy(array.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return array;
}

/// Bodies as Python sees them. A view of a field is made when it is asked for: to make all of them
/// after each step would be a share of a short one.
class Fields {
 public:
  /// Of the simulation at any time, read-only.
  explicit Fields(py::object simulation) : simulation_(std::move(simulation)) {}
  /// Of `bodies` until `end_call`, and then of the simulation.
  Fields(py::object simulation, const Bodies& bodies, bool writable)
      : simulation_(std::move(simulation)), during_call_(&bodies), writable_(writable) {}
  void end_call() {
    during_call_ = nullptr;
    writable_ = false;
  }

  /// A view of the owned rows; none where bodies have no such field.
  py::object get(const std::string& name) const {
    py::object found = py::none();
    const Bodies& of = bodies();
    for_each_field(of, [&](const auto& info, const auto& field) {
      const bool changeable = writable_ && info.field != Field::id;
      if (info.name == name) found = view(field.data(), of.owned, simulation_, changeable);
    });
    return found;
  }
  std::vector<std::string> names() const {
    std::vector<std::string> all;
    for_each_field(bodies(), [&](const auto& info, const auto&) { all.emplace_back(info.name); });
    return all;
  }
  Index rows() const { return bodies().owned; }

 private:
  const Bodies& bodies() const {
    return during_call_ ? *during_call_ : simulation_.cast<Running&>().get().bodies();
  }

  py::object simulation_;  // keeps the memory
  const Bodies* during_call_ = nullptr;
  bool writable_ = false;
};

/// Calls `f(fields)` with those of `bodies`, which may be gone when it returns.
template <class F>
void call_with_fields(const py::handle& simulation, const Bodies& bodies, bool writable, F&& f) {
  const auto owner = py::reinterpret_borrow<py::object>(simulation);
  const py::object fields = py::cast(Fields(owner, bodies, writable));
  struct Call {
    Fields& fields;
    ~Call() { fields.end_call(); }
  } call{fields.cast<Fields&>()};
  f(fields);
}

py::dict energies_of(const Energies& e) {
  return py::dict("kinetic"_a = e.kinetic, "pairs"_a = e.pairs, "gravitational"_a = e.gravitational,
                  "dissipated"_a = e.dissipated, "own_work"_a = e.own_work,
                  "prescribed_work"_a = e.prescribed_work);
}

py::dict summary_of(const StepSummary& s) {
  return py::dict("steps"_a = s.steps, "contacts"_a = s.contacts, "residual"_a = s.residual,
                  "converged"_a = s.converged, "overlap"_a = s.overlap);
}

/// Array of the ids i, j of each pair on this rank.
py::array_t<BodyId> pairs_of(const Simulation& simulation) {
  const std::vector<BodyPair> pairs = simulation.pairs();
  py::array_t<BodyId> ids({static_cast<py::ssize_t>(pairs.size()), py::ssize_t{2}});
  auto at = ids.mutable_unchecked<2>();
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    at(static_cast<py::ssize_t>(k), 0) = pairs[k].i;
    at(static_cast<py::ssize_t>(k), 1) = pairs[k].j;
  }
  return ids;
}

}  // namespace

PYBIND11_MODULE(_spall, module) {
  module.doc() = "Spall's library; see the package spall";
  module.attr("version") = SPALL_VERSION;
  py::register_exception<Error>(module, "Error", PyExc_ValueError);
  module.def("rank", [] { return world().rank; });
  module.def("ranks", [] { return world().size; });
  module.def("end", &Running::end_all);
  module.def("end_others", [](const std::string& why) {
    if (session() && session()->world().size > 1) Session::abort_all(why);
  });

  py::class_<Scene>(module, "Scene")
      .def_static("from_file", &Scene::from_file)
      .def_static("from_text", &Scene::from_text)
      .def("add",
           [](Scene& scene, const std::string& material, double radius, double mass,
              const std::array<double, 3>& position, const std::array<double, 3>& velocity,
              const std::array<double, 3>& spin, bool fixed) {
             const auto vector = [](const std::array<double, 3>& v) {
               return Vec3(v[0], v[1], v[2]);
             };
             scene.add({.material = material,
                        .radius = radius,
                        .mass = mass,
                        .position = vector(position),
                        .velocity = vector(velocity),
                        .spin = vector(spin),
                        .fixed = fixed});
           })
      .def("check", [](const Scene& scene) { return check_case(world(), *scene.parts()); })
      .def("run", [](const Scene& scene, const std::string& folder, bool overwrite) {
        return run_case(world(), *scene.parts(), folder,
                        overwrite ? Former::overwrite : Former::refuse);
      });
  module.def("resume", [](const std::string& file, const std::string& folder, bool overwrite,
                          const std::vector<std::string>& overrides, bool stored_case) {
    const Former former = overwrite ? Former::overwrite : Former::refuse;
    return resume_case(world(), file, {folder, former, overrides, stored_case});
  });

  py::class_<Fields>(module, "Fields")
      .def("get", &Fields::get)
      .def("names", &Fields::names)
      .def("__len__", &Fields::rows);
  py::class_<Running>(module, "Simulation")
      .def(py::init<const Scene&>())
      .def_property_readonly("time", [](Running& r) { return r.get().time(); })
      .def_property_readonly("steps", [](Running& r) { return r.get().steps(); })
      .def_property_readonly("phase", [](Running& r) { return r.get().phase_name(); })
      .def_property_readonly("over", [](Running& r) { return r.get().over(); })
      .def("step", [](Running& r, int most) { return summary_of(r.get().step(most)); })
      .def("run_until",
           [](Running& r, double time, const std::function<void()>& each) {
             r.get().run_until(time, [&] {
               if (each) each();
               if (PyErr_CheckSignals() != 0) throw py::error_already_set();
             });
           })
      .def("energies", [](Running& r) { return energies_of(r.get().energies()); })
      .def("pairs", [](Running& r) { return pairs_of(r.get()); })
      .def("bodies", [](py::object self) { return Fields(std::move(self)); })
      .def("change_bodies",
           [](py::object self, const py::function& change) {
             self.cast<Running&>().get().change_bodies(
                 [&](Bodies& bodies) { call_with_fields(self, bodies, true, change); });
           })
      .def("add_force", [](py::object self, py::function force) {
        // `self` lives longer than its simulation; a reference to it would keep both for ever.
        const py::handle owner = self;
        self.cast<Running&>().get().add_force(
            [force, owner](const Bodies& bodies, std::span<Vec3> forces) {
              call_with_fields(owner, bodies, false, [&](const py::object& fields) {
                force(fields, view(forces.data(), bodies.owned, owner, true));
              });
            });
      });
}
