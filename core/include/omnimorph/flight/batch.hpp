// Many flights at once: as many side by side as a register has lanes, and groups of them in every thread.
//
// A thread takes the next group, flies it from beginning to end, and takes another: the whole of a group stays in the
// cache of one core, whatever the number of flights. What a flight gives depends neither on its lane nor on its thread.
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

/// One thing in which flights differ: `width` numbers of the settings, `at` from their beginning on, a row for each
/// flight.
struct Varied {
    std::ptrdiff_t at;
    int width;
    const double* rows;
};

/// The rows of a flight that is recorded.
struct RecordedFlight {
    long flight;
    Record record;
};

/// Flights 0 … n − 1 of a batch; flight k has the noise of flight first + k.
struct BatchParts {
    LoopSettings<double, 0> settings;
    Reference reference;
    FlightLimits limits;
    long flights;
    std::vector<Varied> varied;
    std::vector<RecordedFlight> recorded;
    double* sums;          // n_flight_sums a flight
    FlightStatus* status;  // `flying` until the flight is over; one a flight, as what follows
    long* last_step;
};

namespace batch {

inline constexpr long steps_between_checks = 512;  // whether to stop

/// Vehicles beyond the last flight are copies of it that stay on the ground.
OMNIMORPH_FN long flight_of(long first, int lane, long flights) {
    return first + lane < flights ? first + lane : flights - 1;
}

/// The settings of flight k.
inline LoopSettings<double, 0> settings_of(const BatchParts& parts, long k) {
    LoopSettings<double, 0> settings = parts.settings;
    for (const Varied& varied : parts.varied)
        std::copy_n(varied.rows + k * varied.width, varied.width, reinterpret_cast<double*>(&settings) + varied.at);
    if (!parts.varied.empty()) derive(settings);
    return settings;
}

/// Fly the flights from `first` on that fit into the lanes of T, to their ends or until `stop`; what came of them goes
/// to `parts`.
template <class T, int N> void fly_group(const BatchParts& parts, long first, const std::atomic<bool>& stop) {
    constexpr int lanes = lane_count<T>;
    const auto settings = std::make_unique<LoopSettings<T, N>>(convert<LoopSettings<T, N>>(parts.settings));
    PerLane<Record, T> records{};
    for (int l = 0; l < lanes; ++l) {
        put_lane(*settings, l, settings_of(parts, flight_of(first, l, parts.flights)));
        for (const RecordedFlight& recorded : parts.recorded)
            if (recorded.flight == first + l) records[l] = recorded.record;
    }
    FlightLimits limits = parts.limits;
    limits.noise.flight += static_cast<std::uint32_t>(first);
    const auto flight = std::make_unique<Flight<T, N>>(*settings, parts.reference, limits, records);
    for (int l = 0; l < lanes; ++l)
        if (first + l >= parts.flights) flight->end(l, FlightStatus::completed);

    FlightMetrics<T, N> metrics(settings->controller.model);
    while (!flight->is_over() && !stop)
        flight->advance(steps_between_checks, [&](const Desired<T>& now) { metrics.add(*flight, now); });
    for (int l = 0; l < lanes && first + l < parts.flights; ++l) {
        write_sums(metrics.sums(), l, parts.sums + (first + l) * n_flight_sums);
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
    ThreadPool(int threads, long flights, int lanes, FlyGroup fly_group)
        : flights_(flights), lanes_(lanes), fly_group_(std::move(fly_group)), at_work_(threads) {
        for (int t = 0; t < threads; ++t) threads_.emplace_back([this] { work(); });
    }
    ThreadPool(const ThreadPool&) = delete;
    ThreadPool& operator=(const ThreadPool&) = delete;
    ~ThreadPool() {
        stop();
        for (std::thread& thread : threads_) thread.join();
    }

    /// Ask the threads to stop; flights that are not complete are abandoned.
    void stop() { stop_ = true; }

    /// Wait for the end, but not longer than so many seconds; true if all threads are done. What went wrong in one is
    /// thrown.
    bool wait(double seconds) {
        std::unique_lock<std::mutex> lock(mutex_);
        const bool done =
            changed_.wait_for(lock, std::chrono::duration<double>(seconds), [this] { return at_work_ == 0; });
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
