// The closed loop: reference, measurement, controller, plant, and a record of every physics step.
#pragma once

#include "controller.hpp"
#include "plant.hpp"
#include "reference.hpp"

namespace omnimorph {

enum class FlightStatus { flying, completed, lost, not_finite, diverged };

/// Where the rows of a flight go: plain arrays of the caller, row after row, or nowhere (null).
struct Record {
    double *p = nullptr, *R = nullptr, *v = nullptr, *w = nullptr;
    double *desired_p = nullptr, *desired_R = nullptr, *desired_v = nullptr, *desired_w = nullptr;
    double *thrust = nullptr, *speed = nullptr, *tilt = nullptr, *tilt_command = nullptr;
    double *wrench_asked = nullptr, *wrench_achieved = nullptr, *cost = nullptr, *kkt_residual = nullptr;
    std::int8_t* active = nullptr;
};

struct FlightSettings {
    long steps;             // physics steps in all
    int control_every;      // physics steps between control steps
    double lost_beyond;     // m from the reference
    NoiseKey noise;
};

/// One flight of one vehicle (T is a scalar); a control step is measure, decide, send, and then `control_every` physics steps.
template <class T, int N> class Flight {
  public:
    Plant<T, N> plant;
    Controller<T, N> controller;
    long step = 0;
    FlightStatus status = FlightStatus::flying;

    Flight(const PlantSettings<T, N>& plant_settings, const Vehicle<T, N>& model, const ControllerSettings<T, N>& controller_settings,
           const Reference& reference, const Motion<T>& start, const Command<T, N>& command, const FlightSettings& settings, const Record& record)
        : plant(plant_settings, start, command),
          controller(model, controller_settings, command),
          reference_(reference),
          settings_(settings),
          record_(record),
          noise_memory_(MeasurementNoise<T>::at_rest()) {}

    /// The motion as the controller is told it.
    Motion<T> measure() {
        return plant.settings().measurement_noise.measure(plant.motion, settings_.noise, static_cast<std::uint32_t>(step / settings_.control_every),
                                                          noise_memory_);
    }

    Desired<T> desired() const { return reference_.at(step, time()); }
    double time() const { return double(step) * plant.settings().step; }
    bool control_is_due() const { return step % settings_.control_every == 0; }

    /// Fly on for at most `most_steps` physics steps with the controller of the core.
    void advance(long most_steps) {
        for (long k = 0; k < most_steps && status == FlightStatus::flying; ++k) {
            const Desired<T> now = desired();
            if (control_is_due() && step < settings_.steps) decide(controller.step(measure(), now));
            integrate(now, Vec6<T>::zero());
        }
    }

    /// Put a command on its way to the motors; it is what the record shows until the next one.
    void decide(const Allocation<T, N>& allocation) {
        decided_ = allocation;
        plant.send(step, allocation.command);
    }
    const Allocation<T, N>& decided() const { return decided_; }

    /// A controller outside gave a number that is not finite: the flight ends here, with this row as its last.
    void refuse_command() {
        write_row(desired());
        status = FlightStatus::not_finite;
    }

    /// Record this row, then one physics step; the last row is recorded only.
    void integrate(const Desired<T>& now, const Vec6<T>& pushed) {
        write_row(now);
        judge(now);
        if (status != FlightStatus::flying) return;
        plant.advance(step, pushed);
        ++step;
    }

  private:
    void judge(const Desired<T>& now) {
        const Vec3<T> e = now.p - plant.motion.p;
        const T distance2 = dot(e, e), turning = dot(plant.motion.w, plant.motion.w);
        if (!(is_finite(distance2) && is_finite(turning))) {
            status = FlightStatus::diverged;
        } else if (distance2 > T(settings_.lost_beyond * settings_.lost_beyond)) {
            status = FlightStatus::lost;
        } else if (step == settings_.steps) {
            status = FlightStatus::completed;
        }
    }

    static void put(double* column, long row, int width, const T* values) {
        if (column == nullptr) return;
        for (int c = 0; c < width; ++c) column[row * width + c] = values[c];
    }

    void write_row(const Desired<T>& now) {
        if (record_.p == nullptr) return;
        const int n = plant.settings().vehicle.n_rotors, m = plant.settings().vehicle.n_servos;
        const Motion<T>& x = plant.motion;
        put(record_.p, step, 3, x.p.a);
        put(record_.R, step, 9, x.R.a[0]);
        put(record_.v, step, 3, x.v.a);
        put(record_.w, step, 3, x.w.a);
        put(record_.desired_p, step, 3, now.p.a);
        put(record_.desired_R, step, 9, now.R.a[0]);
        put(record_.desired_v, step, 3, now.v.a);
        put(record_.desired_w, step, 3, now.w.a);
        put(record_.thrust, step, n, decided_.command.thrust.a);
        put(record_.tilt_command, step, m, decided_.command.tilt.a);
        put(record_.speed, step, n, plant.actuators.speed.a);
        put(record_.tilt, step, m, plant.actuators.tilt.a);
        put(record_.wrench_asked, step, 6, decided_.wrench_asked.a);
        put(record_.wrench_achieved, step, 6, plant.wrench_achieved().a);
        put(record_.cost, step, 1, &decided_.cost);
        put(record_.kkt_residual, step, 1, &decided_.kkt_residual);
        for (int i = 0; i < n; ++i) record_.active[step * n + i] = static_cast<std::int8_t>(decided_.active[i]);
    }

    const Reference& reference_;
    FlightSettings settings_;
    Record record_;
    Allocation<T, N> decided_ = controller.last;
    typename MeasurementNoise<T>::State noise_memory_;
};

}  // namespace omnimorph
