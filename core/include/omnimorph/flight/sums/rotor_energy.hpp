// What it costs to turn the rotors: drag over the steps that end in the rows, and the energy that it took to spin them
// up, of which slowing down gives nothing back.
#pragma once

#include "summed_row.hpp"

namespace omnimorph {

template <class T> struct RotorEnergy {
    CompensatedSum<T> drag_power, kinetic_energy_gained;  // W, all rows but the first; J
    T speed_max = T(0);                                   // rad/s

    static constexpr auto fields() {
        using S = RotorEnergy;
        return field_list(field("drag_power", &S::drag_power),
                          field("kinetic_energy_gained", &S::kinetic_energy_gained), field("speed_max", &S::speed_max));
    }

    template <int N> OMNIMORPH_FN void add(const SummedRow<T, N>& row) {
        T gained = T(0), fastest = T(0);
        for (int i = 0; i < row.model.n_rotors; ++i) {
            const T speed = abs(row.x.plant.actuators.speed[i]), squared = speed * speed;
            fastest = max(fastest, speed);
            if (row.is_first) continue;
            const T squared_before = row.before.speed[i] * row.before.speed[i];
            gained += T(0.5) * row.model.spin_inertia[i] * max(squared - squared_before, T(0));
        }
        if (!row.is_first) drag_power.add(row.counted(row.drag_power));
        kinetic_energy_gained.add(row.counted(gained));
        row.raise(speed_max, fastest);
    }
};

}  // namespace omnimorph
