// One reader of what others write, for libFuzzer: whatever the bytes are, it reads them or throws
// Error. SPALL_READER chooses it: each is a program of its own, made and run by fuzz.py.
// SPDX-License-Identifier: BSD-3-Clause
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>

#include "../described_hdf5.hpp"
#include "keys/units.hpp"
#include "output/fclib.hpp"
#include "output/restart.hpp"
#include "output/series.hpp"
#include "output/stored_bodies.hpp"
#include "scene/case.hpp"
#include "spall/comm.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

std::string folder;  // of this process, in memory

Comm self() {
  return Comm(MPI_COMM_SELF);
}

std::string file_of(const std::string& name, const std::string& bytes) {
  const std::string path = folder + "/" + name;
  std::ofstream(path, std::ios::binary) << bytes;
  return path;
}

/// A file as `text` describes it; false where it describes none.
bool describes_hdf5(const std::string& path, const std::string& text) {
  try {
    write_hdf5(path, text);
    return true;
  } catch (const std::exception&) {
    return false;
  }
}

void units(const std::string& text) {
  parse_quantity(text, dimension::speed);
}

/// Lines "--set KEY=VALUE" before a case are changes of it.
void cases(const std::string& text) {
  std::vector<std::string> changes;
  std::size_t at = 0;
  while (text.compare(at, 6, "--set ") == 0) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    changes.push_back(text.substr(at + 6, end - at - 6));
    at = std::min(end + 1, text.size());
  }
  const Case first = parse_case(text.substr(at), folder + "/x.toml", changes);
  parse_case(first.text, first.file, first.overrides);  // as a restart file keeps it
}

void meshes(const std::string& text) {
  SurfaceMesh::from_obj(text, "x.obj", 1).depth(Vec3::Zero());
}

void stored(const std::string& text) {
  Case packed;
  packed.groups.emplace_back().packing.file = folder + "/x.h5";
  if (describes_hdf5(packed.groups[0].packing.file, text)) with_stored_bodies(packed);
}

void contacts(const std::string& text) {
  if (describes_hdf5(folder + "/x.h5", text)) read_fclib(folder + "/x.h5", self());
}

void restarts(const std::string& text) {
  if (describes_hdf5(folder + "/x.h5", text)) read_restart(self(), folder + "/x.h5");
}

/// The bytes of an HDF5 file itself: refused by its seal, but where it is the one that was sealed.
void seals(const std::string& bytes) {
  check_seal(self(), file_of("x.h5", bytes));
}

void series(const std::string& text) {
  file_of("series.csv", text);
  Series(self(), folder, {{"energy", "J"}, {"contacts", ""}}, 2, {.count = 2}).write_hdf5();
}

const std::map<std::string, void (*)(const std::string&)> readers = {
    {"units", units},       {"cases", cases},       {"meshes", meshes}, {"stored", stored},
    {"contacts", contacts}, {"restarts", restarts}, {"seals", seals},   {"series", series}};
void (*reader)(const std::string&) = nullptr;

}  // namespace
}  // namespace spall

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  static spall::Session session;
  spall::reader = spall::readers.at(std::getenv("SPALL_READER"));
  spall::folder = "/dev/shm/spall_fuzz_" + std::to_string(getpid());
  std::filesystem::create_directories(spall::folder);
  std::atexit([] { std::filesystem::remove_all(spall::folder); });
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  try {
    spall::reader(std::string(reinterpret_cast<const char*>(data), size));
  } catch (const spall::Error&) {
  }
  return 0;
}
