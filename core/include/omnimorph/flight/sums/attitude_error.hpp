// How far the attitude is from the desired one.
#pragma once

#include "summed_row.hpp"

namespace omnimorph {

template <class T> struct AttitudeError {
    CompensatedSum<T> angle, angle_squared;  // between R and R_d, rad
    T angle_max = T(0);
    CompensatedSum<T> sine;        // ‖e_R‖
    CompensatedSum<T> last_angle;  // over the last second

    static constexpr auto fields() {
        using S = AttitudeError;
        return field_list(field("angle", &S::angle), field("angle_squared", &S::angle_squared),
                          field("angle_max", &S::angle_max), field("sine", &S::sine),
                          field("last_angle", &S::last_angle));
    }

    template <int N> OMNIMORPH_FN void add(const SummedRow<T, N>& row) {
        const Mat3<T> R_error = transpose_times(row.x.plant.motion.R, row.desired.R);
        const Vec3<T> e_R = vee_of_skew_part(R_error);
        const T size = sqrt(dot(e_R, e_R)), cosine = T(0.5) * (R_error[0][0] + R_error[1][1] + R_error[2][2] - T(1));
        const T now = atan2(size, cosine);
        angle.add(row.counted(now));
        angle_squared.add(row.counted(now * now));
        row.raise(angle_max, now);
        sine.add(row.counted(size));
        if (row.is_in_last_second) last_angle.add(row.counted(now));
    }
};

}  // namespace omnimorph
