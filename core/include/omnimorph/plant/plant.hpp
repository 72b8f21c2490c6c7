// The plant: actuators with their imperfections, then the forces, then the rigid body, one physics step at a time.
//
// The angular state of the integrators is the whole angular momentum in B, L = J w + H, with H = sum I_i k_i w_i z_i
// that of the spinning rotors (zero unless the effect RotorMomentum is on). dL/dt = tau - w x L then holds the
// gyroscopic torque, the reaction to spinning up and the torque of tilting a spinning rotor at once, without a
// derivative of any of them.
#pragma once

#include "../math/so3.hpp"
#include "rotors.hpp"

namespace omnimorph {

/// The motion, the actuators, and what the rotors do to the body as they are.
template <class T, int N> struct PlantState {
    Motion<T> motion;
    Actuators<T, N> actuators;
    Load<T> load;

    static constexpr auto fields() {
        return field_list(field("motion", &PlantState::motion), field("actuators", &PlantState::actuators),
                          field("load", &PlantState::load));
    }
};

/// A plant whose actuators are as a command asks.
template <class T, int N>
OMNIMORPH_FN PlantState<T, N> plant_at(const Plant<T, N>& plant, const Motion<T>& motion,
                                       const Command<T, N>& command) {
    PlantState<T, N> state{};
    state.motion = motion;
    for (int i = 0; i < plant.n(); ++i) {
        state.actuators.speed[i] = speed_for(plant, i, command.thrust[i]);
        state.actuators.rest_left[i] = T(0);
    }
    state.actuators.tilt = command.tilt;
    state.load = rotor_load(plant, state.actuators);
    return state;
}

/// The actuators a step later: commands pass the laws of rotors, and of servos and their stops.
template <class T, int N>
OMNIMORPH_FN void actuate(const Plant<T, N>& plant, const Command<T, N>& command, ActuatorStep step,
                          Actuators<T, N>& actuators) {
    for (int i = 0; i < plant.n(); ++i) {
        const Rotor<T> rotor{actuators.speed[i], actuators.rest_left[i]};
        T aim = speed_for(plant, i, command.thrust[i]);
        const auto pass = [&](const auto& law) {
            if (law.active) aim = law.follow(i, aim, rotor, step);
        };
        for_each(plant.settings.rotor_laws, pass);
        actuators.speed[i] = aim;
    }
    const Vehicle<T, N>& vehicle = plant.settings.vehicle;
    for (int j = 0; j < plant.m(); ++j) {
        T way = command.tilt[j] - actuators.tilt[j];
        const auto pass = [&](const auto& law) {
            if (law.active) way = law.travel(j, way, step);
        };
        for_each(plant.settings.servo_laws, pass);
        actuators.tilt[j] = clamp(actuators.tilt[j] + way, vehicle.angle_min[j], vehicle.angle_max[j]);
    }
}

/// The sum of a push from outside and of every force of the plant, force in W and torque in B.
template <class T, int N>
OMNIMORPH_FN Vec6<T> forces_at(const Plant<T, N>& plant, const Moment<T, N>& now, const Vec6<T>& push) {
    Vec6<T> sum = push;
    const auto add = [&](const auto& force) {
        if (force.active) sum = sum + force.wrench(now);
    };
    for_each(plant.settings.forces, add);
    return sum;
}

template <class T, int N>
OMNIMORPH_FN Vec3<T> linear_acceleration(const Plant<T, N>& plant, const Mat3<T>& R, const Vec6<T>& rotors,
                                         const Vec6<T>& forces) {
    Vec3<T> a = plant.inverse_mass * (R * force_of(rotors) + force_of(forces));
    a[2] -= T(gravity);
    return a;
}

/// New velocities from the present pose and the new actuators, then the pose from the new velocities (as ODE does).
template <class T, int N>
OMNIMORPH_FN void semi_implicit_euler(const Plant<T, N>& plant, const Command<T, N>& command, double time,
                                      const Vec6<T>& push, PlantState<T, N>& state) {
    const T h = T(plant.settings.step);
    const Vehicle<T, N>& vehicle = plant.settings.vehicle;
    Motion<T>& motion = state.motion;
    Vec3<T> L = vehicle.inertia * motion.w + state.load.momentum;
    actuate(plant, command, {plant.settings.step}, state.actuators);
    state.load = rotor_load(plant, state.actuators);
    const Vec6<T> forces = forces_at<T, N>(plant, {motion, state.actuators, time}, push);
    motion.v = motion.v + h * linear_acceleration(plant, motion.R, state.load.wrench, forces);
    motion.p = motion.p + h * motion.v;
    L = L + h * (torque_of(state.load.wrench) + torque_of(forces) - cross(motion.w, L));
    motion.w = vehicle.inertia_inverse * (L - state.load.momentum);
    motion.R = motion.R * exp_so3(h * motion.w);
}

/// Rates of change of position, velocity, attitude (in the Lie algebra) and angular momentum.
template <class T> struct MotionRates {
    Vec3<T> p, v, attitude, L;
};

/// Rates of change after going on from the motion at the start for `share` seconds along `k`.
template <class T, int N>
OMNIMORPH_FN MotionRates<T> rates_along(const Plant<T, N>& plant, const MotionRates<T>& k, double share,
                                        const PlantState<T, N>& start, const Vec3<T>& L_start, const Load<T>& load,
                                        const Actuators<T, N>& actuators, double time, const Vec6<T>& push) {
    const T h = T(share);
    const Vec3<T> attitude = h * k.attitude, L = L_start + h * k.L;
    const Vec3<T> w = plant.settings.vehicle.inertia_inverse * (L - load.momentum);
    const Motion<T> motion{start.motion.p + h * k.p, start.motion.v + h * k.v, start.motion.R * exp_so3(attitude), w};
    const Vec6<T> forces = forces_at<T, N>(plant, {motion, actuators, time + share}, push);
    return {motion.v, linear_acceleration(plant, motion.R, load.wrench, forces), exp_so3_rate(attitude, w),
            torque_of(load.wrench) + torque_of(forces) - cross(w, L)};
}

/// Classical fourth order, the attitude in the Lie algebra (H. Munthe-Kaas, BIT 38, 1998); the actuators are advanced
/// exactly to the middle and to the end of the step.
template <class T, int N>
OMNIMORPH_FN void runge_kutta_4(const Plant<T, N>& plant, const Command<T, N>& command, double time,
                                const Vec6<T>& push, PlantState<T, N>& state) {
    const double h = plant.settings.step;
    const Vec3<T> L = plant.settings.vehicle.inertia * state.motion.w + state.load.momentum;
    Actuators<T, N> at_start = state.actuators;
    actuate(plant, command, {0}, at_start);
    const Load<T> load_start = rotor_load(plant, at_start);
    Actuators<T, N> at_middle = at_start;
    actuate(plant, command, {h / 2}, at_middle);
    const Load<T> load_middle = rotor_load(plant, at_middle);
    state.actuators = at_middle;
    actuate(plant, command, {h / 2}, state.actuators);
    state.load = rotor_load(plant, state.actuators);

    const MotionRates<T> none{Vec3<T>::zero(), Vec3<T>::zero(), Vec3<T>::zero(), Vec3<T>::zero()};
    const MotionRates<T> k1 = rates_along(plant, none, 0, state, L, load_start, at_start, time, push);
    const MotionRates<T> k2 = rates_along(plant, k1, h / 2, state, L, load_middle, at_middle, time, push);
    const MotionRates<T> k3 = rates_along(plant, k2, h / 2, state, L, load_middle, at_middle, time, push);
    const MotionRates<T> k4 = rates_along(plant, k3, h, state, L, state.load, state.actuators, time, push);
    const auto change = [&](Vec3<T> MotionRates<T>::* of) {
        return T(h / 6) * (k1.*of + T(2) * (k2.*of) + T(2) * (k3.*of) + k4.*of);
    };
    Motion<T>& motion = state.motion;
    motion.p = motion.p + change(&MotionRates<T>::p);
    motion.v = motion.v + change(&MotionRates<T>::v);
    motion.R = motion.R * exp_so3(change(&MotionRates<T>::attitude));
    motion.w = plant.settings.vehicle.inertia_inverse * (L + change(&MotionRates<T>::L) - state.load.momentum);
}

/// One physics step, number `step` of the flight, under a command and a push from outside (force in W, torque in B).
template <class T, int N>
OMNIMORPH_FN void advance(const Plant<T, N>& plant, const Command<T, N>& command, long step, const Vec6<T>& push,
                          PlantState<T, N>& state) {
    const double time = double(step) * plant.settings.step;
    if (plant.settings.integrator == Integrator::semi_implicit_euler) {
        semi_implicit_euler(plant, command, time, push, state);
    } else {
        runge_kutta_4(plant, command, time, push, state);
    }
    if (step % 1024 == 1023) state.motion.R = projected(state.motion.R);
}

}  // namespace omnimorph
