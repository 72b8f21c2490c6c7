// What flights are judged by, added up row by row while they fly: `omnimorph.results.metrics` says what each number
// means and makes the metrics of these sums.
#pragma once

#include "flight.hpp"

namespace omnimorph {

/// A sum over many rows that keeps what is small beside it (W. Kahan, "Further remarks on reducing truncation errors",
/// Communications of the ACM 8, 1965): in single precision a flight's sums would else lose four of their seven digits.
template <class T> struct CompensatedSum {
    T sum = T(0), excess = T(0);

    void add(const T& x) {
        const T addend = x - excess, next = sum + addend;
        excess = (next - sum) - addend;
        sum = next;
    }
    explicit operator T() const { return sum; }
};

/// The rows of the flights in the lanes of T, summed up.
template <class T> struct FlightSums {
    T rows = T(0);                                        // from the first to the last whose numbers are all finite
    CompensatedSum<T> distance, distance_squared;         // ‖p − p_d‖, m
    T distance_max = T(0);                                //
    CompensatedSum<T> angle, angle_squared;               // between R and R_d, rad
    T angle_max = T(0);                                   //
    CompensatedSum<T> sine;                               // ‖e_R‖
    CompensatedSum<T> drag_power, kinetic_energy_gained;  // W, all rows but the first; J
    CompensatedSum<T> tilt;                               // rad, over servos too
    T tilt_min = T(1e30), tilt_max = T(-1e30);            // beyond any servo
    T saturated_rows = T(0);                              //
    T speed_max = T(0);                                   // rad/s
    T kkt_residual_max = T(0);                            // NaN if a residual is none
    T unproven_steps = T(0);                      // control steps whose residual is larger than what proves an answer
    T last_rows = T(0);                           // of the last second of the whole flight, as what follows
    CompensatedSum<T> last_distance, last_angle;  //

    static constexpr auto fields() {
        using S = FlightSums;
        return std::make_tuple(
            field("rows", &S::rows), field("distance", &S::distance), field("distance_squared", &S::distance_squared),
            field("distance_max", &S::distance_max), field("angle", &S::angle),
            field("angle_squared", &S::angle_squared), field("angle_max", &S::angle_max), field("sine", &S::sine),
            field("drag_power", &S::drag_power), field("kinetic_energy_gained", &S::kinetic_energy_gained),
            field("tilt", &S::tilt), field("tilt_min", &S::tilt_min), field("tilt_max", &S::tilt_max),
            field("saturated_rows", &S::saturated_rows), field("speed_max", &S::speed_max),
            field("kkt_residual_max", &S::kkt_residual_max), field("unproven_steps", &S::unproven_steps),
            field("last_rows", &S::last_rows), field("last_distance", &S::last_distance),
            field("last_angle", &S::last_angle));
    }
};
inline constexpr double last_second = 1.0;
inline constexpr int n_flight_sums = std::tuple_size_v<decltype(FlightSums<double>::fields())>;

/// The sums of one lane, in the order of the fields.
template <class T> void write_sums(const FlightSums<T>& sums, int lane_number, double* to) {
    for_each_field(sums, [&](const auto&, const auto& sum) { *to++ = double(lane(static_cast<T>(sum), lane_number)); });
}

/// The sums of the flights in the lanes of T.
template <class T, int N> class FlightMetrics {
  public:
    /// The kinetic energy of the rotors is that of the model's spin inertias, their drag power that of the plant.
    explicit FlightMetrics(const Vehicle<T, N>& model) : spin_inertia_(model.spin_inertia) {}

    const FlightSums<T>& sums() const { return sums_; }

    /// Add the row that the flight has come to; for a vehicle whose flight is over, nothing.
    void add(const Flight<T, N>& flight, const Desired<T>& now) {
        const PlantState<T, N>& plant = flight.state().plant;
        const Allocation<T, N>& decided = flight.state().decided;
        n_ = flight.loop().plant.n();
        m_ = flight.loop().plant.m();
        counts_ = counts_ & (flight.flying() & is_finite(sum_of(plant)));
        sums_.rows += counted(T(1));
        add_errors(plant.motion, now, flight.time_left() < last_second);
        add_rotors(plant.actuators, flight.loop().plant.settings.vehicle, flight.state().step == 0);
        for (int j = 0; j < m_; ++j) {
            const T tilt = plant.actuators.tilt[j];
            sums_.tilt.add(counted(tilt));
            raise(sums_.tilt_max, tilt);
            sums_.tilt_min = select(counts_ & (tilt < sums_.tilt_min), tilt, sums_.tilt_min);
        }
        T bounds = T(0);
        for (int i = 0; i < n_; ++i) bounds += abs(decided.active[i]);
        sums_.saturated_rows += counted(select(bounds > T(0), T(1), T(0)));
        sums_.kkt_residual_max =
            select(counts_, max_or_nan(sums_.kkt_residual_max, decided.kkt_residual), sums_.kkt_residual_max);
        if (!flight.control_is_due()) return;
        sums_.unproven_steps += counted(select(decided.kkt_residual > T(box_qp::proven<T>), T(1), T(0)));
    }

  private:
    /// Not finite if one of the numbers is not.
    T sum_of(const PlantState<T, N>& plant) const {
        T sum = T(0);
        for (int r = 0; r < 3; ++r) {
            sum += plant.motion.p[r];
            for (int c = 0; c < 3; ++c) sum += plant.motion.R[r][c];
        }
        for (int i = 0; i < n_; ++i) sum += plant.actuators.speed[i];
        for (int j = 0; j < m_; ++j) sum += plant.actuators.tilt[j];
        return sum;
    }

    void add_errors(const Motion<T>& motion, const Desired<T>& now, bool is_last) {
        const Vec3<T> e_p = motion.p - now.p;
        const T distance_squared = dot(e_p, e_p), distance = sqrt(distance_squared);
        const Mat3<T> R_error = transpose_times(motion.R, now.R);
        const Vec3<T> e_R = vee_of_skew_part(R_error);
        const T sine = sqrt(dot(e_R, e_R)), cosine = T(0.5) * (R_error[0][0] + R_error[1][1] + R_error[2][2] - T(1));
        const T angle = atan2(sine, cosine);
        sums_.distance.add(counted(distance));
        sums_.distance_squared.add(counted(distance_squared));
        raise(sums_.distance_max, distance);
        sums_.angle.add(counted(angle));
        sums_.angle_squared.add(counted(angle * angle));
        raise(sums_.angle_max, angle);
        sums_.sine.add(counted(sine));
        if (!is_last) return;
        sums_.last_rows += counted(T(1));
        sums_.last_distance.add(counted(distance));
        sums_.last_angle.add(counted(angle));
    }

    /// Drag over the step that ended here; the energy that it took to spin up, of which slowing down gives nothing
    /// back.
    void add_rotors(const Actuators<T, N>& actuators, const Vehicle<T, N>& truth, bool first) {
        T power = T(0), gained = T(0), fastest = T(0);
        for (int i = 0; i < n_; ++i) {
            const T speed = abs(actuators.speed[i]), squared = speed * speed;
            if (!first) {
                power += truth.drag_coefficient[i] * (squared * speed);
                gained += T(0.5) * spin_inertia_[i] * max(squared - speed_squared_[i], T(0));
            }
            speed_squared_[i] = squared;
            fastest = max(fastest, speed);
        }
        sums_.drag_power.add(counted(power));
        sums_.kinetic_energy_gained.add(counted(gained));
        raise(sums_.speed_max, fastest);
    }

    T counted(const T& x) const { return select(counts_, x, T(0)); }
    void raise(T& largest, const T& x) const { largest = select(counts_ & (x > largest), x, largest); }

    FlightSums<T> sums_;
    PerRotor<T, N> spin_inertia_, speed_squared_{};
    Mask<T> counts_ = T(0) == T(0);
    int n_ = 0, m_ = 0;
};

}  // namespace omnimorph
