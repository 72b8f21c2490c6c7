// How far the position is from the desired one.
#pragma once

#include "summed_row.hpp"

namespace omnimorph {

template <class T> struct PositionError {
    CompensatedSum<T> distance, distance_squared;  // ‖p − p_d‖, m
    T distance_max = T(0);
    CompensatedSum<T> last_distance;  // over the last second

    static constexpr auto fields() {
        using S = PositionError;
        return field_list(field("distance", &S::distance), field("distance_squared", &S::distance_squared),
                          field("distance_max", &S::distance_max), field("last_distance", &S::last_distance));
    }

    template <int N> OMNIMORPH_FN void add(const SummedRow<T, N>& row) {
        const Vec3<T> e_p = row.x.plant.motion.p - row.desired.p;
        const T squared = dot(e_p, e_p), now = sqrt(squared);
        distance.add(row.counted(now));
        distance_squared.add(row.counted(squared));
        row.raise(distance_max, now);
        if (row.is_in_last_second) last_distance.add(row.counted(now));
    }
};

}  // namespace omnimorph
