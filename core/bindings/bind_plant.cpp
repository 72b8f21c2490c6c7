// The plant's settings: the true vehicle, the integrator, and one method an effect.
#include <nanobind/stl/string.h>

#include <cmath>

#include "bind.hpp"

namespace omnimorph::python {

namespace {

using Settings = PlantSettings<double, 0>;

int rotors(const Settings& s) { return s.vehicle.n_rotors; }

/// e^(-h/tau); a time constant of zero means at once.
double kept(double step, double time_constant) { return time_constant > 0 ? std::exp(-step / time_constant) : 0.0; }

void make(Settings* self, const AnyVehicle& truth, const Array& command_coefficient, double step, const std::string& integrator) {
    new (self) Settings(truth.n_rotors);
    self->vehicle = truth;
    self->command_coefficient = per_rotor_from(command_coefficient, truth.n_rotors, "command_coefficient");
    self->step = step;
    if (integrator == "runge-kutta-4") {
        self->integrator = Integrator::runge_kutta_4;
    } else if (integrator != "semi-implicit-euler") {
        throw nb::value_error("an integrator is semi-implicit-euler or runge-kutta-4");
    }
    for (int i = 0; i < truth.n_rotors; ++i) self->effectiveness[i] = 1.0;
}

void add_rotor_lag(Settings& s, const Array& up, const Array& down) {
    const auto tau_up = per_rotor_from(up, rotors(s), "up"), tau_down = per_rotor_from(down, rotors(s), "down");
    s.rotor_lag.active = true;
    for (int i = 0; i < rotors(s); ++i) {
        s.rotor_lag.keep_up[i] = kept(s.actuator_step(), tau_up[i]);
        s.rotor_lag.keep_down[i] = kept(s.actuator_step(), tau_down[i]);
    }
}

void add_speed_limits(Settings& s, const Array& speed_min, const Array& speed_max) {
    s.speed_limits.active = true;
    s.speed_limits.speed_min = per_rotor_from(speed_min, rotors(s), "speed_min");
    s.speed_limits.speed_max = per_rotor_from(speed_max, rotors(s), "speed_max");
}

void add_dead_band(Settings& s, const Array& smallest, double reversal_time) {
    s.dead_band.active = true;
    s.dead_band.smallest = per_rotor_from(smallest, rotors(s), "smallest");
    s.dead_band.reversal_time = reversal_time;
}

void add_servo_lag(Settings& s, const Array& time_constant) {
    const auto tau = per_servo_from(time_constant, s.vehicle.n_servos, "time_constant");
    s.servo_lag.active = true;
    for (int j = 0; j < s.vehicle.n_servos; ++j) s.servo_lag.keep[j] = kept(s.actuator_step(), tau[j]);
}

void add_servo_rate_limit(Settings& s, const Array& rate) {
    const auto most = per_servo_from(rate, s.vehicle.n_servos, "rate");
    s.servo_rate_limit.active = true;
    for (int j = 0; j < s.vehicle.n_servos; ++j) s.servo_rate_limit.most[j] = most[j] * s.actuator_step();
}

void add_measurement_noise(Settings& s, const Array& deviation, const Array& filter_cutoff, double control_period) {
    expect_size(deviation, 4, "deviation");
    expect_size(filter_cutoff, 4, "filter_cutoff");
    s.measurement_noise.active = true;
    for (int k = 0; k < 4; ++k) {
        const double cutoff = filter_cutoff.data()[k];
        s.measurement_noise.deviation[k] = deviation.data()[k];
        s.measurement_noise.filter_gain[k] = cutoff > 0 ? 1.0 - std::exp(-control_period * cutoff) : 1.0;
    }
}

void set_effectiveness(Settings& s, const Array& share) { s.effectiveness = per_rotor_from(share, rotors(s), "share"); }

void add_constant_wrench(Settings& s, const Array& wrench) {
    expect_size(wrench, 6, "wrench");
    s.disturbance.active = true;
    s.disturbance.constant = s.disturbance.constant + vector_from<6>(wrench.data());
}

void set_sine_wrench(Settings& s, const Array& amplitude, double frequency, double phase) {
    expect_size(amplitude, 6, "amplitude");
    s.disturbance.active = true;
    s.disturbance.amplitude = vector_from<6>(amplitude.data());
    s.disturbance.frequency = frequency;
    s.disturbance.phase = phase;
}

void set_wrench_profile(Settings& s, const Array& times, const Array& wrenches) {
    expect_size(wrenches, 6 * times.size(), "wrenches");
    s.disturbance.active = true;
    s.disturbance.times.assign(times.data(), times.data() + times.size());
    s.disturbance.wrenches.assign(wrenches.data(), wrenches.data() + wrenches.size());
}

}  // namespace

void bind_plant(nb::module_& m) {
    using namespace nb::literals;
    nb::class_<Settings>(m, "PlantSettings")
        .def("__init__", &make, "truth"_a, "command_coefficient"_a, "step"_a, "integrator"_a)
        .def("set_delay", [](Settings& s, int steps) { s.delay_steps = steps; }, "steps"_a)
        .def("add_rotor_lag", &add_rotor_lag, "up"_a, "down"_a)
        .def("add_speed_limits", &add_speed_limits, "speed_min"_a, "speed_max"_a)
        .def("add_dead_band", &add_dead_band, "smallest"_a, "reversal_time"_a)
        .def("add_servo_lag", &add_servo_lag, "time_constant"_a)
        .def("add_servo_rate_limit", &add_servo_rate_limit, "rate"_a)
        .def("add_measurement_noise", &add_measurement_noise, "deviation"_a, "filter_cutoff"_a, "control_period"_a)
        .def("add_constant_wrench", &add_constant_wrench, "wrench"_a)
        .def("set_sine_wrench", &set_sine_wrench, "amplitude"_a, "frequency"_a, "phase"_a)
        .def("set_wrench_profile", &set_wrench_profile, "times"_a, "wrenches"_a)
        .def("set_effectiveness", &set_effectiveness, "share"_a)
        .def("add_rotor_momentum", [](Settings& s) { s.rotor_momentum = true; })
        .def("add_interference", [](Settings& s, bool blade_element) {
            s.interference = true;
            s.wake_model = blade_element ? WakeModel::blade_element : WakeModel::published;
        }, "blade_element"_a);
}

}  // namespace omnimorph::python
