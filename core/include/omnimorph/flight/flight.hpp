// A flight from its beginning to its end: the loop, stepped along a reference, judged and recorded in every physics
// step.
#pragma once

#include <memory>

#include "../control/reference.hpp"
#include "../plant/acceleration.hpp"
#include "record.hpp"

namespace omnimorph {

struct FlightLimits {
    long steps;          // physics steps in all
    double lost_beyond;  // m from the reference
    NoiseKey noise;      // of the vehicle in lane 0
};

/// Flights of as many vehicles as T has lanes, side by side: one, if T is a scalar. They share the reference and the
/// times; those in the lanes after the first are the flights that follow.
///
/// A vehicle whose flight has ended is parked where the reference is, and the others fly on; what it does is not
/// recorded.
template <class T, int N> class Flight {
  public:
    static constexpr int vehicles = lane_count<T>;
    using Records = PerLane<Record, T>;

    Flight(const Flight&) = delete;
    Flight& operator=(const Flight&) = delete;
    Flight(const LoopSettings<T, N>& settings, const Reference& reference, const FlightLimits& limits,
           const Records& records)
        : loop_(settings, limits.steps, limits.noise),
          reference_(reference),
          lost_beyond_(limits.lost_beyond),
          records_(records) {
        x_ = start_ = state_at(loop_, settings.start);
        for (int l = 0; l < vehicles; ++l) is_recorded_ = is_recorded_ || records_[l].is_kept();
        if (settings.plant.delay.steps == 0) return;
        delay_line_ = std::make_unique<DelayLine<T, N>>(DelayLine<T, N>::beginning_with(settings.start.command));
        memory_.delay_line = delay_line_.get();
    }

    const Loop<T, N>& loop() const { return loop_; }
    const FlightState<T, N>& state() const { return x_; }
    /// Null, if commands are in force at once.
    const DelayLine<T, N>* delay_line() const { return delay_line_.get(); }

    /// Go on from another state of this flight; its caches begin empty.
    void restore(const FlightState<T, N>& state, const DelayLine<T, N>* delay_line) {
        x_ = state;
        memory_.allocation = AllocationCache<T, N>{};
        if (delay_line_ != nullptr && delay_line != nullptr) *delay_line_ = *delay_line;
        find_flying();
    }

    /// The estimate of the motion in this control step, the same however often it is asked for.
    Motion<T> measure() {
        return estimate_in_step(loop_.sensors, loop_.estimator, x_.plant.motion, loop_.noise, control_step(loop_, x_),
                                x_.estimator)
            .motion;
    }

    /// What the sensors read of the motion in this control step.
    Motion<T> measured() const {
        const Measurement<T> m = sense(loop_.sensors, x_.plant.motion, loop_.noise, control_step(loop_, x_));
        return m.has_error ? with_error(m.motion, m.error) : m.motion;
    }
    /// The estimate of the motion in this control step from what sensors outside have read.
    Motion<T> estimate_from(const Motion<T>& measured) {
        const Measurement<T> m{measured, Vec<T, 12>::zero(), false, control_step(loop_, x_)};
        return estimate(loop_.estimator, m, x_.estimator).motion;
    }

    /// As it is now, under the push of the last physics step.
    Vec6<T> acceleration() const { return omnimorph::acceleration(loop_.plant, x_.plant, x_.step, x_.push); }

    Desired<T> desired() const { return cast<T>(desired_at(reference_, x_.step, time())); }
    double time() const { return double(x_.step) * loop_.plant.settings.step; }
    /// Time to the end of the whole flight, s.
    double time_left() const { return double(loop_.steps - x_.step) * loop_.plant.settings.step; }
    bool control_is_due() const { return omnimorph::control_is_due(loop_, x_); }

    FlightStatus status(int vehicle = 0) const { return x_.status[vehicle]; }
    /// The row at which its flight ended, or has come to.
    long last_step(int vehicle = 0) const {
        return status(vehicle) == FlightStatus::flying ? x_.step : x_.last_step[vehicle];
    }
    /// Those whose flight goes on.
    const Mask<T>& flying() const { return flying_; }
    bool is_over() const { return !any(flying_); }

    /// Fly on for at most `most_steps` physics steps with the controller of the core; `watch` sees each row before it
    /// is judged.
    template <class Watch> void advance(long most_steps, Watch&& watch) {
        for (long k = 0; k < most_steps && !is_over(); ++k) {
            const Desired<T> now = desired();
            if (any(!flying_) && control_is_due()) park(now);
            step(loop_, now, Vec6<T>::zero(), x_, memory_, [&] {
                watch(now);
                return finish_row(now);
            });
        }
    }
    void advance(long most_steps) {
        advance(most_steps, [](const Desired<T>&) {});
    }

    /// Go on with another controller from the last command of this one.
    void change_controller(const ControllerSettings<T, N>& s) {
        loop_.tracking = s.tracking;
        loop_.allocation = s.allocation;
        loop_.problem = allocation_problem(s.model, s.allocation.weights);
        memory_.allocation = AllocationCache<T, N>{};
        x_.tracking = TrackingState<T>{};
    }

    void set_effectiveness(const PerRotor<T, N>& share) {
        loop_.plant.set_effectiveness(share);
        x_.plant.load = rotor_load(loop_.plant, x_.plant.actuators);
    }

    /// Let the core's controller decide, and send its command.
    const Allocation<T, N>& control(const Motion<T>& known, const Desired<T>& now) {
        allocate(loop_, known, track(loop_.tracking, known, now, x_.tracking), x_, memory_);
        return x_.decided;
    }

    /// Answer a demand from outside, and send the command.
    const Allocation<T, N>& answer(const Motion<T>& known, const Demand<T>& demand) {
        allocate(loop_, known, demand, x_, memory_);
        return x_.decided;
    }

    /// Put a command from outside on its way to the motors; it is what the record shows until the next one.
    void command(const Allocation<T, N>& decided) {
        x_.decided = decided;
        x_.decided_outside = true;
        send(loop_, x_, memory_);
    }

    /// Record this row, then one physics step under a push; the last row is recorded only.
    void integrate(const Desired<T>& now, const Vec6<T>& push) {
        if (!finish_row(now)) return;
        x_.push = push;
        move(loop_, push, x_, memory_);
    }

    /// Record and judge this row; whether the flight goes on.
    bool finish_row() { return finish_row(desired()); }

    /// A plant outside, so many physics steps under a push later: its motion, actuators and wrench, and the thrusts,
    /// if it says them.
    void place(const PlantState<T, N>& outside, const PerRotor<T, N>* thrust, const Vec6<T>& push, long steps_later) {
        x_.push = push;
        x_.plant = outside;
        x_.plant.load = rotor_load(loop_.plant, outside.actuators);
        x_.plant.load.wrench = outside.load.wrench;
        if (thrust != nullptr) {
            if (!thrust_outside_) thrust_outside_ = std::make_unique<PerRotor<T, N>>();
            *thrust_outside_ = *thrust;
        }
        x_.step += steps_later;
    }

    /// The flight of a vehicle ends here, after this row.
    void end(int vehicle, FlightStatus status) {
        if (x_.status[vehicle] != FlightStatus::flying) return;
        x_.status[vehicle] = status;
        x_.last_step[vehicle] = x_.step;
        find_flying();
    }

    /// Something outside cannot go on: the flight ends with this row as its last.
    void end_here(FlightStatus status) {
        record(desired());
        end(0, status);
    }

  private:
    /// Record and judge a row; whether any vehicle flies on.
    bool finish_row(const Desired<T>& now) {
        record(now);
        judge(now);
        return !is_over();
    }

    void find_flying() {
        T flies = T(0);
        for (int l = 0; l < vehicles; ++l) set_lane(flies, l, Scalar<T>(x_.status[l] == FlightStatus::flying));
        flying_ = flies > T(0);
    }

    /// Whether all that was decided is numbers; from outside comes a command alone.
    Mask<T> decided_in_numbers() const {
        T sum = x_.decided_outside ? T(0) : x_.decided.cost + x_.decided.kkt_residual;
        for (int i = 0; i < loop_.plant.n(); ++i) sum += x_.decided.command.thrust[i];
        for (int j = 0; j < loop_.plant.m(); ++j) sum += x_.decided.command.tilt[j];
        return is_finite(sum);
    }

    void judge(const Desired<T>& now) {
        const Motion<T>& motion = x_.plant.motion;
        const Vec3<T> e = now.p - motion.p;
        const T distance2 = dot(e, e), turning = dot(motion.w, motion.w);
        const Mask<T> finite = is_finite(distance2) & is_finite(turning);
        const Mask<T> near = finite & !(distance2 > T(lost_beyond_ * lost_beyond_));
        const Mask<T> commanded = control_is_due() ? decided_in_numbers() : T(0) == T(0);
        if (x_.step != loop_.steps && !any(flying_ & !(near & commanded))) return;
        for (int l = 0; l < vehicles; ++l) {
            if (!is_set(finite, l)) {
                end(l, FlightStatus::diverged);
            } else if (!is_set(commanded, l)) {
                end(l, FlightStatus::not_finite);
            } else if (!is_set(near, l)) {
                end(l, FlightStatus::lost);
            } else if (x_.step == loop_.steps) {
                end(l, FlightStatus::completed);
            }
        }
    }

    /// Give the vehicles whose flight has ended harmless numbers: nothing of a lane reaches another, but
    /// what is solved in many steps takes as many for all.
    void park(const Desired<T>& now) {
        const auto back = [&](T& x, const T& to) { x = select(flying_, x, to); };
        Motion<T>& motion = x_.plant.motion;
        for (int r = 0; r < 3; ++r) {
            back(motion.p[r], now.p[r]);
            back(motion.v[r], now.v[r]);
            back(motion.w[r], now.w[r]);
            for (int c = 0; c < 3; ++c) back(motion.R[r][c], now.R[r][c]);
        }
        for (int i = 0; i < loop_.plant.n(); ++i) {
            back(x_.plant.actuators.speed[i], start_.plant.actuators.speed[i]);
            back(x_.decided.command.thrust[i], start_.decided.command.thrust[i]);
            back(x_.decided.active[i], T(0));
        }
        for (int j = 0; j < loop_.plant.m(); ++j) {
            back(x_.plant.actuators.tilt[j], start_.decided.command.tilt[j]);
            back(x_.decided.command.tilt[j], start_.decided.command.tilt[j]);
        }
    }

    void record(const Desired<T>& now) const {
        if (!is_recorded_) return;
        const auto thrust = thrust_outside_ ? *thrust_outside_ : thrust_actual(loop_.plant, x_.plant.actuators);
        const Row<T, N> row{x_, now, thrust};
        const Count<N> n = loop_.plant.settings.vehicle.n_rotors;
        for (int l = 0; l < vehicles; ++l)
            if (records_[l].is_kept() && x_.status[l] == FlightStatus::flying)
                write_row(row, n, loop_.plant.m(), l, x_.step, records_[l]);
    }

    Loop<T, N> loop_;
    Reference reference_;
    double lost_beyond_;
    Records records_;
    bool is_recorded_ = false;
    FlightState<T, N> x_, start_;
    StepMemory<T, N> memory_;
    std::unique_ptr<DelayLine<T, N>> delay_line_;
    std::unique_ptr<PerRotor<T, N>> thrust_outside_;  // of a plant outside that says it
    Mask<T> flying_ = T(0) == T(0);
};

}  // namespace omnimorph
