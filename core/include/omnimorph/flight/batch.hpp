// Many flights at once: as many side by side as a register has lanes, and groups of them in every thread.
//
// A thread takes the next group, flies it from beginning to end, and takes another: the whole of a group stays in the cache
// of one core, whatever the number of flights. What a flight gives depends neither on its lane nor on its thread.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "../math/pack.hpp"
#include "metrics.hpp"

namespace omnimorph {

/// In what flights differ: one row of numbers a flight, or nothing (null) where they are alike.
struct Variation {
    const double *mass = nullptr, *inertia = nullptr;                          // factors of the plant's vehicle
    const double *thrust_coefficient = nullptr, *drag_coefficient = nullptr;   // factors, one a rotor
    const double* effectiveness = nullptr;                                     // share of the thrust, one a rotor
    const double* centre_of_mass = nullptr;                                    // m, in B, three numbers
    const double *rotor_lag = nullptr, *noise = nullptr;                       // factors of time constants and deviations
    const double* wrench = nullptr;                                            // N in W and N m in B, six numbers
};

/// The rows of a flight that is recorded.
struct RecordedFlight {
    long flight;
    Record record;
};

/// Flights 0 … n − 1 of a batch; flight k has the noise of flight first + k.
struct BatchParts {
    PlantSettings<double, 0> plant;
    Vehicle<double, 0> model;
    ControllerSettings<double, 0> controller;
    const Reference* reference;
    Command<double, 0> command;
    FlightSettings settings;
    long flights;
    const Motion<double>* start;         // one a flight
    Variation variation;
    std::vector<RecordedFlight> recorded;
    FlightSums* sums;                    // one a flight, as what follows
    FlightStatus* status;                // `flying` until the flight is over
    long* last_step;
};

namespace batch {

inline constexpr long steps_between_looks = 512;  // at whether to stop

/// Vehicles beyond the last flight are copies of it that stay on the ground.
OMNIMORPH_FN long flight_of(long first, int lane, long flights) { return first + lane < flights ? first + lane : flights - 1; }

/// Put the numbers of flight k into one lane of the plant.
template <class T, int N> void vary(PlantSettings<T, N>& plant, const BatchParts& parts, int index, long k) {
    const Variation& by = parts.variation;
    const Vehicle<double, 0>& base = parts.plant.vehicle;
    Vehicle<T, N>& vehicle = plant.vehicle;
    const auto put = [&](T& x, double value) { set_lane(x, index, Scalar<T>(value)); };
    const int n = base.n_rotors;
    if (by.mass != nullptr) put(vehicle.mass, base.mass * by.mass[k]);
    if (by.inertia != nullptr) {
        Mat3<double> J = base.inertia;
        for (int r = 0; r < 3; ++r)
            for (int c = 0; c < 3; ++c) J[r][c] *= by.inertia[k];
        const Mat3<double> J_inverse = inverse(J);
        for (int r = 0; r < 3; ++r)
            for (int c = 0; c < 3; ++c) put(vehicle.inertia[r][c], J[r][c]), put(vehicle.inertia_inverse[r][c], J_inverse[r][c]);
    }
    for (int i = 0; i < n; ++i) {
        if (by.thrust_coefficient != nullptr) put(vehicle.thrust_coefficient[i], base.thrust_coefficient[i] * by.thrust_coefficient[k * n + i]);
        if (by.drag_coefficient != nullptr) put(vehicle.drag_coefficient[i], base.drag_coefficient[i] * by.drag_coefficient[k * n + i]);
        if (by.effectiveness != nullptr) put(plant.effectiveness[i], by.effectiveness[k * n + i]);
        if (by.rotor_lag != nullptr) {  // e^(-h/(f tau)) = (e^(-h/tau))^(1/f)
            put(plant.rotor_lag.keep_up[i], std::pow(parts.plant.rotor_lag.keep_up[i], 1 / by.rotor_lag[k]));
            put(plant.rotor_lag.keep_down[i], std::pow(parts.plant.rotor_lag.keep_down[i], 1 / by.rotor_lag[k]));
        }
        for (int r = 0; r < 3 && by.centre_of_mass != nullptr; ++r) put(vehicle.position[i][r], base.position[i][r] - by.centre_of_mass[3 * k + r]);
    }
    for (int c = 0; c < 4 && by.noise != nullptr; ++c)
        put(plant.measurement_noise.deviation[c], parts.plant.measurement_noise.deviation[c] * by.noise[k]);
    if (by.wrench == nullptr) return;
    plant.disturbance.active = true;
    for (int r = 0; r < 6; ++r) put(plant.disturbance.constant[r], parts.plant.disturbance.constant[r] + by.wrench[6 * k + r]);
}

template <class T> void put_motion(Motion<T>& many, int index, const Motion<double>& one) {
    for (int r = 0; r < 3; ++r) {
        set_lane(many.p[r], index, Scalar<T>(one.p[r]));
        set_lane(many.v[r], index, Scalar<T>(one.v[r]));
        set_lane(many.w[r], index, Scalar<T>(one.w[r]));
        for (int c = 0; c < 3; ++c) set_lane(many.R[r][c], index, Scalar<T>(one.R[r][c]));
    }
}

/// Fly the flights from `first` on that fit into the lanes of T, to their ends or until `stop`; what is over is told in `parts`.
template <class T, int N> void fly_group(const BatchParts& parts, long first, const std::atomic<bool>& stop) {
    constexpr int lanes = lane_count<T>;
    const int n = parts.model.n_rotors, m = parts.model.n_servos;
    PlantSettings<T, N> plant(parts.plant);
    Motion<T> start{};
    std::array<Record, lanes> records{};
    for (int l = 0; l < lanes; ++l) {
        const long k = flight_of(first, l, parts.flights);
        vary(plant, parts, l, k);
        put_motion(start, l, parts.start[k]);
        for (const RecordedFlight& recorded : parts.recorded)
            if (recorded.flight == first + l) records[l] = recorded.record;
    }
    FlightSettings settings = parts.settings;
    settings.noise.flight += static_cast<std::uint32_t>(first);
    const auto model = convert<Vehicle<T, N>>(parts.model);
    const Command<T, N> command{cast<T, N>(parts.command.thrust, n), cast<T>(parts.command.tilt, m)};
    const auto flight = std::make_unique<Flight<T, N>>(plant, model, ControllerSettings<T, N>(parts.controller, n, m), *parts.reference, start, command,
                                                       settings, records);
    for (int l = 0; l < lanes; ++l)
        if (first + l >= parts.flights) flight->end(l, FlightStatus::completed);

    FlightMetrics<T, N> metrics(model);
    while (!flight->is_over() && !stop) flight->advance(steps_between_looks, [&](const Desired<T>& now) { metrics.add(*flight, now); });
    for (int l = 0; l < lanes && first + l < parts.flights; ++l) {
        parts.sums[first + l] = metrics.of(l);
        parts.last_step[first + l] = flight->last_step(l);
        parts.status[first + l] = flight->status(l);
    }
}

}  // namespace batch

/// Threads that share out groups of flights among them.
class ThreadPool {
  public:
    using FlyGroup = std::function<void(long first, const std::atomic<bool>& stop)>;

    /// Begin to fly `flights` flights, `lanes` at a time.
    ThreadPool(int threads, long flights, int lanes, FlyGroup fly_group) : flights_(flights), lanes_(lanes), fly_group_(std::move(fly_group)), at_work_(threads) {
        for (int t = 0; t < threads; ++t) threads_.emplace_back([this] { work(); });
    }
    ThreadPool(const ThreadPool&) = delete;
    ThreadPool& operator=(const ThreadPool&) = delete;
    ~ThreadPool() {
        stop();
        for (std::thread& thread : threads_) thread.join();
    }

    /// Ask for an end: what is in the air is given up.
    void stop() { stop_ = true; }

    /// Wait for the end, but not longer than so many seconds; true if all threads are done. What went wrong in one is thrown.
    bool wait(double seconds) {
        std::unique_lock<std::mutex> lock(mutex_);
        const bool done = changed_.wait_for(lock, std::chrono::duration<double>(seconds), [this] { return at_work_ == 0; });
        if (done && problem_ != nullptr) std::rethrow_exception(std::exchange(problem_, nullptr));
        return done;
    }

    /// How many flights are done.
    long done() const { return done_; }

  private:
    void work() {
        try {
            for (long first = lanes_ * next_++; first < flights_ && !stop_; first = lanes_ * next_++) {
                fly_group_(first, stop_);
                if (!stop_) done_ += std::min<long>(lanes_, flights_ - first);
            }
        } catch (...) {
            const std::lock_guard<std::mutex> lock(mutex_);
            problem_ = std::current_exception();
            stop_ = true;
        }
        const std::lock_guard<std::mutex> lock(mutex_);
        --at_work_;
        changed_.notify_all();
    }

    long flights_, lanes_;
    FlyGroup fly_group_;
    std::atomic<long> next_{0}, done_{0};
    std::atomic<bool> stop_{false};
    std::mutex mutex_;
    std::condition_variable changed_;
    int at_work_;
    std::exception_ptr problem_;
    std::vector<std::thread> threads_;
};

}  // namespace omnimorph
