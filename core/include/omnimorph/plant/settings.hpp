// What a plant is: the true vehicle, the integrator and its step, and the imperfections.
#pragma once

#include "../model/interference.hpp"
#include "effects.hpp"

namespace omnimorph {

enum class Integrator { semi_implicit_euler, runge_kutta_4 };

/// Spinning rotors hold angular momentum.
struct RotorMomentum {
    bool active = false;
    static constexpr auto fields() { return field_list(derived("active", &RotorMomentum::active)); }
};

/// Rotors in line take thrust from one another.
struct InterferenceSettings {
    bool active = false;
    WakeModel model = WakeModel::published;
    static constexpr auto fields() {
        return field_list(derived("active", &InterferenceSettings::active),
                          field("model", &InterferenceSettings::model));
    }
};

/// Everything about the plant that a flight does not change.
template <class T, int N> struct PlantSettings {
    Vehicle<T, N> vehicle;               // the true one
    PerRotor<T, N> command_coefficient;  // c_f by which the motor drivers turn thrust into speed: the controller's
    PerRotor<T, N> effectiveness;        // share of its thrust that each rotor still gives
    double step = 0;                     // s
    Integrator integrator = Integrator::semi_implicit_euler;
    CommandDelay delay;
    RotorMomentum rotor_momentum;
    InterferenceSettings interference;
    RotorLaws<T, N> rotor_laws;
    ServoLaws<T> servo_laws;
    Forces<T> forces;

    static constexpr auto fields() {
        using S = PlantSettings;
        return field_list(field("vehicle", &S::vehicle), field("command_coefficient", &S::command_coefficient),
                          field("effectiveness", &S::effectiveness), field("step", &S::step),
                          field("integrator", &S::integrator), field("command-delay", &S::delay),
                          field("rotor-momentum", &S::rotor_momentum), field("interference", &S::interference),
                          field("rotor_laws", &S::rotor_laws), field("servo_laws", &S::servo_laws),
                          field("forces", &S::forces));
    }

    /// The integrator's steps of the actuators: Runge and Kutta need them in the middle too.
    OMNIMORPH_FN double actuator_step() const { return integrator == Integrator::runge_kutta_4 ? step / 2 : step; }
};

namespace plant {

template <class Law, class = void> inline constexpr bool has_derive = false;
template <class Law>
inline constexpr bool has_derive<Law, std::void_t<decltype(derive(std::declval<Law&>(), 0, 0, 0.0))>> = true;

/// Set what follows from the other fields of each law.
template <class Laws> OMNIMORPH_FN void derive_each(Laws& laws, int n, int m, double h) {
    const auto derive_one = [&](auto& law) {
        using Law = std::decay_t<decltype(law)>;
        static_assert(has_derive<Law> || !fields::has_derived<Law>, "derive(law, n, m, h) is missing");
        if constexpr (has_derive<Law>) derive(law, n, m, h);
    };
    for_each(laws, derive_one);
}

}  // namespace plant

template <int N> OMNIMORPH_FN void derive(PlantSettings<double, N>& s) {
    const int n = s.vehicle.n_rotors, m = s.vehicle.n_servos;
    derive(s.vehicle);
    plant::derive_each(s.rotor_laws, n, m, s.actuator_step());
    plant::derive_each(s.servo_laws, n, m, s.actuator_step());
    plant::derive_each(s.forces, n, m, s.actuator_step());
}

}  // namespace omnimorph
