// The rotors: what wrench they make in B, what angular momentum they hold, and what each of them loads its hub with.
#pragma once

#include "../model/interference.hpp"
#include "settings.hpp"

namespace omnimorph {

/// The wrench in B, and the rotors' own angular momentum in B.
template <class T> struct Load {
    Vec6<T> wrench;
    Vec3<T> momentum;

    static constexpr auto fields() {
        return field_list(field("wrench", &Load::wrench), field("momentum", &Load::momentum));
    }
};

/// What follows from a plant's settings, so that a step need not work it out.
template <class T, int N> struct Plant {
    PlantSettings<T, N> settings;
    T inverse_mass;
    PerRotor<T, N> speed_squared_per_thrust;  // 1/c_f of the motor drivers
    WrenchMap<T, N> wrench_of_speeds;         // signed squared speeds -> wrench
    WrenchMap<T, N> force_of_speeds;          // the same without drag
    Interference<T, N> wakes;

    OMNIMORPH_FN explicit Plant(const PlantSettings<T, N>& s)
        : settings(s),
          inverse_mass(T(1) / s.vehicle.mass),
          wrench_of_speeds(map_of_speeds(s, s.vehicle.drag_coefficient)),
          force_of_speeds(map_of_speeds(s, PerRotor<T, N>{})),
          wakes(s.vehicle, s.interference.model) {
        for (int i = 0; i < s.vehicle.n_rotors; ++i) speed_squared_per_thrust[i] = T(1) / s.command_coefficient[i];
    }

    OMNIMORPH_FN int n() const { return settings.vehicle.n_rotors; }
    OMNIMORPH_FN int m() const { return settings.vehicle.n_servos; }

    /// From now on each rotor gives this share of its thrust; its drag torque stays, as with a torn blade.
    OMNIMORPH_FN void set_effectiveness(const PerRotor<T, N>& share) {
        settings.effectiveness = share;
        wrench_of_speeds = map_of_speeds(settings, settings.vehicle.drag_coefficient);
        force_of_speeds = map_of_speeds(settings, PerRotor<T, N>{});
    }

    OMNIMORPH_FN static WrenchMap<T, N> map_of_speeds(const PlantSettings<T, N>& s, const PerRotor<T, N>& drag) {
        PerRotor<T, N> thrust{};
        for (int i = 0; i < s.vehicle.n_rotors; ++i) thrust[i] = s.effectiveness[i] * s.vehicle.thrust_coefficient[i];
        return WrenchMap<T, N>(s.vehicle, thrust, drag);
    }
};

/// The speed at which a motor driver takes its rotor to give a thrust.
template <class T, int N> OMNIMORPH_FN T speed_for(const Plant<T, N>& plant, int i, const T& thrust) {
    return with_sign(sqrt(abs(thrust) * plant.speed_squared_per_thrust[i]), thrust);
}

/// w|w| of every rotor.
template <class T, int N> OMNIMORPH_FN PerRotor<T, N> signed_squares(const PerRotor<T, N>& speed, int n) {
    PerRotor<T, N> squared;
    for (int i = 0; i < n; ++i) squared[i] = speed[i] * abs(speed[i]);
    return squared;
}

/// What the wakes take: the thrust alone, the drag torque stays.
template <class T, int N>
OMNIMORPH_FN Vec6<T> wrench_lost(const Plant<T, N>& plant, const TiltTrigonometry<T>& trig, const PerRotor<T, N>& speed,
                                 const PerRotor<T, N>& squared) {
    const PerRotor<T, N> kept = plant.wakes.thrust_kept(plant.wakes.weights(trig), speed);
    PerRotor<T, N> lost{};
    for (int i = 0; i < plant.n(); ++i) lost[i] = (T(1) - kept[i]) * squared[i];
    return wrench(plant.force_of_speeds.at(trig), lost, plant.n());
}

/// What the rotors do to the body: the sum of their forces and torques, less what the wakes take, and
/// H = Σ I_i k_i w_i z_i.
template <class T, int N> OMNIMORPH_FN Load<T> rotor_load(const Plant<T, N>& plant, const Actuators<T, N>& actuators) {
    const Vehicle<T, N>& vehicle = plant.settings.vehicle;
    const TiltTrigonometry<T> trig = trigonometry_of(actuators.tilt, plant.m());
    const PerRotor<T, N> squared = signed_squares<T, N>(actuators.speed, plant.n());
    Load<T> load{wrench(plant.wrench_of_speeds.at(trig), squared, plant.n()), Vec3<T>::zero()};
    if (plant.settings.interference.active)
        load.wrench = load.wrench - wrench_lost(plant, trig, actuators.speed, squared);
    if (plant.settings.rotor_momentum.active)
        for (int i = 0; i < plant.n(); ++i)
            load.momentum = load.momentum + (vehicle.spin_inertia[i] * vehicle.spin[i] * actuators.speed[i]) *
                                                rotor_axis(vehicle, i, trig);
    return load;
}

/// The thrust that each rotor gives along its axis now, N: at its actual speed, of its share of effectiveness, and what
/// the wakes of others leave of it.
template <class T, int N>
OMNIMORPH_FN PerRotor<T, N> thrust_actual(const Plant<T, N>& plant, const Actuators<T, N>& actuators) {
    const PlantSettings<T, N>& s = plant.settings;
    PerRotor<T, N> thrust{};
    for (int i = 0; i < plant.n(); ++i) {
        const T coefficient = s.effectiveness[i] * s.vehicle.thrust_coefficient[i];
        thrust[i] = coefficient * (actuators.speed[i] * abs(actuators.speed[i]));
    }
    if (!s.interference.active) return thrust;
    const auto weights = plant.wakes.weights(trigonometry_of(actuators.tilt, plant.m()));
    const PerRotor<T, N> kept = plant.wakes.thrust_kept(weights, actuators.speed);
    for (int i = 0; i < plant.n(); ++i) thrust[i] = kept[i] * thrust[i];
    return thrust;
}

/// The force and the torque with which rotor i loads its hub, in B: its thrust and its drag torque along the axis.
template <class T, int N>
OMNIMORPH_FN Vec6<T> hub_load(const Plant<T, N>& plant, const Actuators<T, N>& actuators, int i) {
    const Vehicle<T, N>& vehicle = plant.settings.vehicle;
    const Vec3<T> axis = rotor_axis(vehicle, i, trigonometry_of(actuators.tilt, plant.m()));
    const T drag = vehicle.spin[i] * vehicle.drag_coefficient[i] * (actuators.speed[i] * abs(actuators.speed[i]));
    return joined(thrust_actual(plant, actuators)[i] * axis, -drag * axis);
}

}  // namespace omnimorph
