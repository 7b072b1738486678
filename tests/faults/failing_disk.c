// A disk that fails: loaded before libc, it lets one call after another of a rank fail, or ends the rank there.
// SPDX-License-Identifier: BSD-3-Clause
//
// FAULT        write, fsync, rename or open, of files below FAULT_FOLDER
// FAULT_AT     the call that fails first, from 1; of `write` the byte
// FAULT_RANK   the rank whose calls fail; none: every rank's
// FAULT_ERRNO  what they fail with
// FAULT_ONCE   if given: that call alone fails, later ones do not
// FAULT_DOES   what else befalls the rank there: kill (SIGKILL), crash (a segmentation fault), memory (no more of it),
//              hang (the call never returns, whatever signals come), stop (SIGSTOP)
// FAULT_MARK   a file that is made when the first call fails
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

static long long done = 0;
static int has_failed = 0;

static int is_watched(const char* path) {
  const char* folder = getenv("FAULT_FOLDER");
  return folder && path && strstr(path, folder) != NULL;
}

static int is_watched_descriptor(int descriptor) {
  char link[64], path[4096];
  snprintf(link, sizeof link, "/proc/self/fd/%d", descriptor);
  const ssize_t length = readlink(link, path, sizeof path - 1);
  if (length < 0) return 0;
  path[length] = 0;
  return is_watched(path);
}

// Instead of a call that fails; returns where the rank lives on.
static void befall(const char* what) {
  if (strcmp(what, "kill") == 0) raise(SIGKILL);
  if (strcmp(what, "crash") == 0) *(volatile int*)0 = 0;
  if (strcmp(what, "stop") == 0) raise(SIGSTOP);
  while (strcmp(what, "hang") == 0) pause();
  const struct rlimit none = {0, 0};
  if (strcmp(what, "memory") == 0) setrlimit(RLIMIT_AS, &none);
}

// Counts `amount`; whether this call fails.
static int fails(const char* call, long long amount) {
  const char *fault = getenv("FAULT"), *rank = getenv("FAULT_RANK");
  const char* own = getenv("OMPI_COMM_WORLD_RANK");
  if (!fault || strcmp(fault, call) != 0) return 0;
  if (rank && own && strcmp(rank, own) != 0) return 0;
  done += amount;
  if (done < atoll(getenv("FAULT_AT"))) return 0;
  if (has_failed && (getenv("FAULT_ONCE") || getenv("FAULT_DOES"))) return 0;
  has_failed = 1;
  const char* mark = getenv("FAULT_MARK");
  if (mark && access(mark, F_OK) != 0) mknod(mark, S_IFREG | 0644, 0);
  if (getenv("FAULT_DOES")) {
    befall(getenv("FAULT_DOES"));
    return 0;
  }
  errno = atoi(getenv("FAULT_ERRNO"));
  return 1;
}

#define REAL(type, name) ((type)dlsym(RTLD_NEXT, name))

ssize_t write(int d, const void* from, size_t n) {
  if (is_watched_descriptor(d) && fails("write", n)) return -1;
  return REAL(ssize_t(*)(int, const void*, size_t), "write")(d, from, n);
}
ssize_t pwrite(int d, const void* from, size_t n, off_t at) {
  if (is_watched_descriptor(d) && fails("write", n)) return -1;
  return REAL(ssize_t(*)(int, const void*, size_t, off_t), "pwrite")(d, from, n, at);
}
ssize_t pwrite64(int d, const void* from, size_t n, off64_t at) {
  if (is_watched_descriptor(d) && fails("write", n)) return -1;
  return REAL(ssize_t(*)(int, const void*, size_t, off64_t), "pwrite64")(d, from, n, at);
}
static long long size_of(const struct iovec* parts, int count) {
  long long size = 0;
  for (int k = 0; k < count; ++k) size += parts[k].iov_len;
  return size;
}
ssize_t writev(int d, const struct iovec* parts, int count) {
  if (is_watched_descriptor(d) && fails("write", size_of(parts, count))) return -1;
  return REAL(ssize_t(*)(int, const struct iovec*, int), "writev")(d, parts, count);
}
ssize_t pwritev(int d, const struct iovec* parts, int count, off_t at) {
  if (is_watched_descriptor(d) && fails("write", size_of(parts, count))) return -1;
  return REAL(ssize_t(*)(int, const struct iovec*, int, off_t), "pwritev")(d, parts, count, at);
}
ssize_t pwritev64(int d, const struct iovec* parts, int count, off64_t at) {
  if (is_watched_descriptor(d) && fails("write", size_of(parts, count))) return -1;
  return REAL(ssize_t(*)(int, const struct iovec*, int, off64_t), "pwritev64")(d, parts, count, at);
}
int fsync(int d) {
  if (is_watched_descriptor(d) && fails("fsync", 1)) return -1;
  return REAL(int (*)(int), "fsync")(d);
}
int rename(const char* from, const char* to) {
  if (is_watched(to) && fails("rename", 1)) return -1;
  return REAL(int (*)(const char*, const char*), "rename")(from, to);
}

// Only what is opened for writing.
static int open_any(const char* name, const char* path, int flags, mode_t mode) {
  if ((flags & (O_WRONLY | O_RDWR | O_CREAT)) && is_watched(path) && fails("open", 1)) return -1;
  return REAL(int (*)(const char*, int, ...), name)(path, flags, mode);
}
#define MODE(flags)                          \
  mode_t mode = 0;                           \
  if ((flags) & (O_CREAT | O_TMPFILE)) {     \
    va_list rest;                            \
    va_start(rest, flags);                   \
    mode = va_arg(rest, mode_t);             \
    va_end(rest);                            \
  }
int open(const char* path, int flags, ...) {
  MODE(flags)
  return open_any("open", path, flags, mode);
}
int open64(const char* path, int flags, ...) {
  MODE(flags)
  return open_any("open64", path, flags, mode);
}
FILE* fopen(const char* path, const char* how) {
  if (how[0] != 'r' && is_watched(path) && fails("open", 1)) return NULL;
  return REAL(FILE * (*)(const char*, const char*), "fopen")(path, how);
}
