// The actual tilts.
#pragma once

#include "summed_row.hpp"

namespace omnimorph {

template <class T> struct Tilts {
    CompensatedSum<T> tilt;                     // rad, over servos too
    T tilt_min = T(1e30), tilt_max = T(-1e30);  // beyond any servo

    static constexpr auto fields() {
        return field_list(field("tilt", &Tilts::tilt), field("tilt_min", &Tilts::tilt_min),
                          field("tilt_max", &Tilts::tilt_max));
    }

    template <int N> OMNIMORPH_FN void add(const SummedRow<T, N>& row) {
        for (int j = 0; j < row.model.n_servos; ++j) {
            const T now = row.x.plant.actuators.tilt[j];
            tilt.add(row.counted(now));
            row.raise(tilt_max, now);
            row.lower(tilt_min, now);
        }
    }
};

}  // namespace omnimorph
