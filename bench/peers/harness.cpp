// Times contestants in one process, interleaved, after it has checked that they agree.
//
//     harness CPU SECONDS REFERENCE < list
//
// A line of the list is a contestant:
//
//     LABEL LIBRARY SYMBOL (torques | accelerations) (by-state | by-joint)
//
// The first one is the reference and supplies the torques for forward dynamics; its library also holds `bench_states`. For each
// contestant, in the order of the list, one line comes out: the least time for one state in ns, and the largest error of
// an answer, relative to the largest in its state. The torques of the reference go to the file REFERENCE, in text.

#include "contestant.h"
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <dlfcn.h>
#include <fstream>
#include <iostream>
#include <sched.h>
#include <string>
#include <time.h>
#include <vector>

using Numbers = std::vector<double>;

struct Contestant {
    std::string label;
    contestant *run;
    bool torques, by_joint;
    Numbers out = Numbers(STATES * JOINTS);
    double least_ns = INFINITY, error = 0;
};

[[noreturn]] static void fail(const std::string &why) {
    std::fprintf(stderr, "harness: %s\n", why.c_str());
    std::exit(1);
}

static void *symbol(const std::string &library, const std::string &name) {
    void *handle = dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
    void *found = handle ? dlsym(handle, name.c_str()) : nullptr;
    if (!found)
        fail(dlerror());
    return found;
}

static double now_ns() {
    timespec t;
    clock_gettime(CLOCK_MONOTONIC_RAW, &t);
    return t.tv_sec * 1e9 + t.tv_nsec;
}

static Numbers by_joint(const Numbers &by_state) {
    Numbers turned(by_state.size());
    for (size_t i = 0; i < STATES; ++i)
        for (size_t j = 0; j < JOINTS; ++j)
            turned[j * STATES + i] = by_state[i * JOINTS + j];
    return turned;
}

// The numbers of a state from each array, one after the other.
static Numbers rows(std::initializer_list<const Numbers *> arrays) {
    Numbers all;
    for (size_t i = 0; i < STATES; ++i)
        for (const Numbers *array : arrays) {
            size_t width = array->size() / STATES;
            all.insert(all.end(), array->begin() + i * width, array->begin() + (i + 1) * width);
        }
    return all;
}

// The largest difference from what must come out, relative to the largest answer of the state.
static double error_of(const Contestant &contestant, const Numbers &wanted) {
    double error = 0;
    for (size_t i = 0; i < STATES; ++i) {
        double size = 0, difference = 0;
        for (size_t j = 0; j < JOINTS; ++j) {
            double found = contestant.out[contestant.by_joint ? j * STATES + i : i * JOINTS + j];
            double want = wanted[i * JOINTS + j];
            size = std::max(size, std::abs(want));
            // Not std::max: a NaN must not get lost.
            if (!(std::abs(found - want) <= difference))
                difference = std::abs(found - want);
        }
        if (!(difference / size <= error))
            error = difference / size;
    }
    return error;
}

int main(int count, char **arguments) {
    if (count != 4)
        fail("harness CPU SECONDS REFERENCE < list");
    cpu_set_t cpus;
    CPU_ZERO(&cpus);
    CPU_SET(std::atoi(arguments[1]), &cpus);
    if (sched_setaffinity(0, sizeof cpus, &cpus))
        fail("cannot stay on one processor");

    std::vector<Contestant> contestants;
    void (*bench_states)(double *, double *, double *) = nullptr;
    std::string label, library, name, answer, layout;
    while (std::cin >> label >> library >> name >> answer >> layout) {
        if (!bench_states)
            bench_states = reinterpret_cast<decltype(bench_states)>(symbol(library, "bench_states"));
        auto run = reinterpret_cast<contestant *>(symbol(library, name));
        contestants.push_back({label, run, answer == "torques", layout == "by-joint"});
    }
    if (contestants.empty())
        fail("nobody to measure");

    Numbers q(STATES * JOINTS), qd(q), qdd(q), turn(2 * q.size());
    bench_states(q.data(), qd.data(), qdd.data());
    for (size_t i = 0; i < q.size(); ++i)
        turn[2 * i] = std::cos(q[i]), turn[2 * i + 1] = std::sin(q[i]);
    Numbers q_by_joint = by_joint(q), qd_by_joint = by_joint(qd), qdd_by_joint = by_joint(qdd);
    Numbers tau(q.size());
    Numbers inverse_rows = rows({&q, &qd, &qdd}), kernel_rows = rows({&turn, &qd, &qdd});
    states states{};
    states.q = q.data(), states.qd = qd.data(), states.qdd = qdd.data(), states.turn = turn.data();
    states.inverse_rows = inverse_rows.data(), states.kernel_rows = kernel_rows.data();
    states.q_by_joint = q_by_joint.data(), states.qd_by_joint = qd_by_joint.data();
    states.qdd_by_joint = qdd_by_joint.data();
    contestants[0].run(&states, tau.data());
    Numbers forward_rows = rows({&q, &qd, &tau});
    states.tau = tau.data(), states.forward_rows = forward_rows.data();

    for (Contestant &contestant : contestants) {
        contestant.run(&states, contestant.out.data());
        contestant.error = error_of(contestant, contestant.torques ? tau : qdd);
    }
    std::ofstream reference(arguments[3]);
    reference.precision(17);
    for (size_t i = 0; i < tau.size(); ++i)
        reference << tau[i] << (i % JOINTS == JOINTS - 1 ? '\n' : ' ');
    if (!reference.flush())
        fail(std::string("cannot write ") + arguments[3]);

    for (double end = now_ns() + std::atof(arguments[2]) * 1e9; now_ns() < end;)
        for (Contestant &contestant : contestants) {
            // Once to warm the caches, once for the clock.
            contestant.run(&states, contestant.out.data());
            double begin = now_ns();
            contestant.run(&states, contestant.out.data());
            contestant.least_ns = std::min(contestant.least_ns, (now_ns() - begin) / STATES);
        }
    for (const Contestant &contestant : contestants)
        std::printf("%s %.3f %.3e\n", contestant.label.c_str(), contestant.least_ns, contestant.error);
}
