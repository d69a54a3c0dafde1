/* Faults of a disk, for LD_PRELOAD: makes calls on files under a folder fail, or the process die at one of them.
 *
 * FAULT_CALL   write, fsync or rename
 * FAULT_PATH   part of the path of the files
 * FAULT_AT     number of the first faulty call, from 1
 * FAULT_EVERY  distance of further faulty calls; 0 for none
 * FAULT_ERROR  error number, or 0 to kill the process before the call
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static atomic_long calls;

static long number(const char *name) {
    const char *text = getenv(name);
    return text ? atol(text) : 0;
}

static int fails(const char *call, const char *path) {
    const char *wanted = getenv("FAULT_CALL"), *part = getenv("FAULT_PATH");
    if (!wanted || !part || strcmp(wanted, call) || !strstr(path, part)) return 0;
    long at = atomic_fetch_add(&calls, 1) + 1, first = number("FAULT_AT"), every = number("FAULT_EVERY");
    if (at != first && !(every > 0 && at > first && (at - first) % every == 0)) return 0;
    long error = number("FAULT_ERROR");
    if (error == 0) raise(SIGKILL);
    errno = (int)error;
    return 1;
}

static int file_fails(const char *call, int file) {
    char link[64], path[4096];
    snprintf(link, sizeof link, "/proc/self/fd/%d", file);
    ssize_t length = readlink(link, path, sizeof path - 1);
    if (length < 0) return 0;
    path[length] = 0;
    return fails(call, path);
}

ssize_t write(int file, const void *bytes, size_t count) {
    static ssize_t (*real)(int, const void *, size_t);
    if (!real) real = dlsym(RTLD_NEXT, "write");
    return file_fails("write", file) ? -1 : real(file, bytes, count);
}

int fsync(int file) {
    static int (*real)(int);
    if (!real) real = dlsym(RTLD_NEXT, "fsync");
    return file_fails("fsync", file) ? -1 : real(file);
}

int rename(const char *from, const char *to) {
    static int (*real)(const char *, const char *);
    if (!real) real = dlsym(RTLD_NEXT, "rename");
    return fails("rename", to) ? -1 : real(from, to);
}
