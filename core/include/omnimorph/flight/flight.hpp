// The closed loop: reference, measurement, controller, plant, and a record of every physics step.
#pragma once

#include <array>
#include <limits>

#include "../control/controller.hpp"
#include "../plant/plant.hpp"
#include "../control/reference.hpp"

namespace omnimorph {

enum class FlightStatus { flying, completed, lost, not_finite, diverged };

/// Where the rows of a flight go: plain arrays of the caller, row after row, or nowhere (null).
struct Record {
    double *p = nullptr, *R = nullptr, *v = nullptr, *w = nullptr;
    double *desired_p = nullptr, *desired_R = nullptr, *desired_v = nullptr, *desired_w = nullptr;
    double *thrust_command = nullptr, *thrust_actual = nullptr, *speed = nullptr;
    double *tilt_command = nullptr, *tilt_actual = nullptr;
    double *wrench_asked = nullptr, *wrench_achieved = nullptr, *cost = nullptr, *kkt_residual = nullptr;
    std::int8_t* active = nullptr;
};

struct FlightSettings {
    long steps;             // physics steps in all
    int control_every;      // physics steps between control steps
    double lost_beyond;     // m from the reference
    NoiseKey noise;         // of the vehicle in lane 0
};

/// Flights of as many vehicles as T has lanes, side by side: one, if T is a scalar. They share the reference and the times;
/// those in the lanes after the first are the flights that follow. A control step is measure, decide, send, and then
/// `control_every` physics steps.
///
/// A vehicle whose flight has ended is parked where the reference is, and the others fly on; what it does is not recorded.
template <class T, int N> class Flight {
  public:
    static constexpr int vehicles = lane_count<T>;
    Plant<T, N> plant;
    Controller<T, N> controller;
    long step = 0;

    Flight(const Flight&) = delete;
    Flight& operator=(const Flight&) = delete;
    Flight(const PlantSettings<T, N>& plant_settings, const Vehicle<T, N>& model, const ControllerSettings<T, N>& controller_settings,
           const Reference& reference, const Motion<T>& start, const Command<T, N>& command, const FlightSettings& settings,
           const std::array<Record, vehicles>& records)
        : plant(plant_settings, start, command),
          controller(model, controller_settings, command),
          reference_(reference),
          settings_(settings),
          records_(records),
          start_command_(command),
          start_speed_(plant.actuators.speed),
          noise_memory_(MeasurementNoise<T>::at_rest()) {
        for (const Record& record : records_) is_recorded_ = is_recorded_ || record.p != nullptr;
        from_outside_ = controller.last;  // the start's command, which nobody decided
        from_outside_.cost = from_outside_.kkt_residual = T(std::numeric_limits<double>::quiet_NaN());
        for (int c = 0; c < 6; ++c) from_outside_.wrench_asked[c] = from_outside_.cost;
        last_step_.fill(0);
        status_.fill(FlightStatus::flying);
    }

    /// The motion as the controller is told it.
    Motion<T> measure() {
        return plant.settings().measurement_noise.measure(plant.motion, settings_.noise, static_cast<std::uint32_t>(step / settings_.control_every),
                                                          noise_memory_);
    }

    Desired<T> desired() const { return cast<T>(reference_.at(step, time())); }
    double time() const { return double(step) * plant.settings().step; }
    bool control_is_due() const { return step % settings_.control_every == 0 && step < settings_.steps; }
    /// How long before the end of the whole flight, s.
    double time_left() const { return double(settings_.steps - step) * plant.settings().step; }

    FlightStatus status(int vehicle = 0) const { return status_[vehicle]; }
    /// The row at which its flight ended, or has come to.
    long last_step(int vehicle = 0) const { return status_[vehicle] == FlightStatus::flying ? step : last_step_[vehicle]; }
    /// Those whose flight goes on.
    const Mask<T>& flying() const { return flying_; }
    bool is_over() const { return !any(flying_); }

    /// Fly on for at most `most_steps` physics steps with the controller of the core; `watch` sees each row before it is
    /// judged.
    template <class Watch> void advance(long most_steps, Watch&& watch) {
        for (long k = 0; k < most_steps && !is_over(); ++k) {
            const Desired<T> now = desired();
            if (control_is_due()) {
                if (any(!flying_)) park(now);
                control(measure(), now);
            }
            watch(now);
            integrate(now, Vec6<T>::zero());
        }
    }
    void advance(long most_steps) {
        advance(most_steps, [](const Desired<T>&) {});
    }

    /// Go on with another controller from the last command of this one.
    void change_controller(const Vehicle<T, N>& model, const ControllerSettings<T, N>& settings) {
        const Allocation<T, N> last = controller.last;
        controller = Controller<T, N>(model, settings, last.command);
        controller.last = last;
    }

    /// Let the core's controller decide, and send its command.
    const Allocation<T, N>& control(const Motion<T>& measured, const Desired<T>& now) {
        decided_ = &controller.step(measured, now);
        plant.send(step, decided_->command);
        return *decided_;
    }

    /// Put a command from outside on its way to the motors; it is what the record shows until the next one.
    void decide(const Allocation<T, N>& allocation) {
        from_outside_ = allocation;
        decided_ = &from_outside_;
        plant.send(step, allocation.command);
    }
    const Allocation<T, N>& decided() const { return *decided_; }

    /// Record this row, then one physics step; the last row is recorded only.
    void integrate(const Desired<T>& now, const Vec6<T>& pushed) {
        write_row(now);
        judge(now);
        if (is_over()) return;
        plant.advance(step, pushed);
        ++step;
    }

    /// The flight of a vehicle ends here, after this row.
    void end(int vehicle, FlightStatus status) {
        if (status_[vehicle] != FlightStatus::flying) return;
        status_[vehicle] = status;
        last_step_[vehicle] = step;
        T flies = T(0);
        for (int l = 0; l < vehicles; ++l) set_lane(flies, l, Scalar<T>(status_[l] == FlightStatus::flying));
        flying_ = flies > T(0);
    }

    /// A controller outside gave a number that is not finite: the flight ends with this row as its last.
    void refuse_command() {
        write_row(desired());
        end(0, FlightStatus::not_finite);
    }

  private:
    /// Whether all that was decided is numbers; from outside comes a command alone.
    Mask<T> decided_in_numbers() const {
        T sum = decided_ == &controller.last ? decided_->cost + decided_->kkt_residual : T(0);
        for (int i = 0; i < plant.settings().vehicle.n_rotors; ++i) sum += decided_->command.thrust[i];
        for (int j = 0; j < plant.settings().vehicle.n_servos; ++j) sum += decided_->command.tilt[j];
        return is_finite(sum);
    }

    void judge(const Desired<T>& now) {
        const Vec3<T> e = now.p - plant.motion.p;
        const T distance2 = dot(e, e), turning = dot(plant.motion.w, plant.motion.w);
        const Mask<T> finite = is_finite(distance2) & is_finite(turning);
        const Mask<T> near = finite & !(distance2 > T(settings_.lost_beyond * settings_.lost_beyond));
        const Mask<T> commanded = control_is_due() ? decided_in_numbers() : T(0) == T(0);
        if (step != settings_.steps && !any(flying_ & !(near & commanded))) return;
        for (int l = 0; l < vehicles; ++l) {
            if (!is_set(finite, l)) {
                end(l, FlightStatus::diverged);
            } else if (!is_set(commanded, l)) {
                end(l, FlightStatus::not_finite);
            } else if (!is_set(near, l)) {
                end(l, FlightStatus::lost);
            } else if (step == settings_.steps) {
                end(l, FlightStatus::completed);
            }
        }
    }

    /// Give the vehicles whose flight has ended numbers that trouble no one: nothing of a lane reaches another, but what is
    /// solved in many steps takes as many for all.
    void park(const Desired<T>& now) {
        const auto back = [&](T& x, const T& to) { x = select(flying_, x, to); };
        Motion<T>& motion = plant.motion;
        for (int r = 0; r < 3; ++r) {
            back(motion.p[r], now.p[r]);
            back(motion.v[r], now.v[r]);
            back(motion.w[r], now.w[r]);
            for (int c = 0; c < 3; ++c) back(motion.R[r][c], now.R[r][c]);
        }
        for (int i = 0; i < plant.settings().vehicle.n_rotors; ++i) {
            back(plant.actuators.speed[i], start_speed_[i]);
            back(controller.last.command.thrust[i], start_command_.thrust[i]);
            back(controller.last.active[i], T(0));
        }
        for (int j = 0; j < plant.settings().vehicle.n_servos; ++j) {
            back(plant.actuators.tilt[j], start_command_.tilt[j]);
            back(controller.last.command.tilt[j], start_command_.tilt[j]);
        }
    }

    void put(double* column, int width, const T* values, int vehicle) const {
        for (int c = 0; c < width; ++c) column[step * width + c] = lane(values[c], vehicle);
    }

    void write_row(const Desired<T>& now) const {
        if (!is_recorded_) return;
        const PerRotor<T, N> thrust_actual = plant.thrust_actual();
        for (int l = 0; l < vehicles; ++l)
            if (records_[l].p != nullptr && status_[l] == FlightStatus::flying) write_row(now, thrust_actual, l);
    }

    void write_row(const Desired<T>& now, const PerRotor<T, N>& thrust_actual, int l) const {
        const int n = plant.settings().vehicle.n_rotors, m = plant.settings().vehicle.n_servos;
        const Motion<T>& x = plant.motion;
        const Record& record = records_[l];
        put(record.p, 3, x.p.a, l);
        put(record.R, 9, x.R.a[0], l);
        put(record.v, 3, x.v.a, l);
        put(record.w, 3, x.w.a, l);
        put(record.desired_p, 3, now.p.a, l);
        put(record.desired_R, 9, now.R.a[0], l);
        put(record.desired_v, 3, now.v.a, l);
        put(record.desired_w, 3, now.w.a, l);
        put(record.thrust_command, n, decided_->command.thrust.a, l);
        put(record.thrust_actual, n, thrust_actual.a, l);
        put(record.speed, n, plant.actuators.speed.a, l);
        put(record.tilt_command, m, decided_->command.tilt.a, l);
        put(record.tilt_actual, m, plant.actuators.tilt.a, l);
        put(record.wrench_asked, 6, decided_->wrench_asked.a, l);
        put(record.wrench_achieved, 6, plant.wrench_achieved().a, l);
        put(record.cost, 1, &decided_->cost, l);
        put(record.kkt_residual, 1, &decided_->kkt_residual, l);
        for (int i = 0; i < n; ++i) record.active[step * n + i] = static_cast<std::int8_t>(lane(decided_->active[i], l));
    }

    const Reference& reference_;
    FlightSettings settings_;
    std::array<Record, vehicles> records_;
    bool is_recorded_ = false;
    Command<T, N> start_command_;
    PerRotor<T, N> start_speed_;
    std::array<FlightStatus, vehicles> status_;
    std::array<long, vehicles> last_step_;
    Mask<T> flying_ = T(0) == T(0);
    Allocation<T, N> from_outside_;
    const Allocation<T, N>* decided_ = &from_outside_;  // or the controller's own, which is too large to be copied each time
    typename MeasurementNoise<T>::State noise_memory_;
};

}  // namespace omnimorph
