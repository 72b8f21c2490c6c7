// What flights are judged by, added up row by row while they fly: `omnimorph.results.metrics` says what each number means and
// makes the metrics of these sums.
#pragma once

#include "../math/elementary.hpp"
#include "flight.hpp"

namespace omnimorph {

/// A sum over many rows that keeps what is small beside it (W. Kahan, "Further remarks on reducing truncation errors",
/// Communications of the ACM 8, 1965): in single precision a flight's sums would else lose four of their seven digits.
template <class T> class CompensatedSum {
  public:
    void add(const T& x) {
        const T wanted = x - excess_, sum = sum_ + wanted;
        excess_ = (sum - sum_) - wanted;
        sum_ = sum;
    }
    const T& value() const { return sum_; }

  private:
    T sum_ = T(0), excess_ = T(0);
};

/// The rows of one flight, summed up.
struct FlightSums {
    double rows;                                        // from the first to the last whose numbers are all finite
    double distance, distance_squared, distance_max;    // ‖p − p_d‖, m
    double angle, angle_squared, angle_max;             // between R and R_d, rad
    double sine;                                        // ‖e_R‖
    double drag_power, kinetic_energy_gained;           // W, all rows but the first; J
    double tilt, tilt_min, tilt_max;                    // rad, over servos too
    double saturated_rows, speed_max, kkt_residual_max; // speed in rad/s; NaN if a residual is none
    double unproven_steps;                              // control steps whose residual is larger than what proves an answer
    double last_rows, last_distance, last_angle;        // of the last second of the whole flight
};
inline constexpr double last_second = 1.0;
inline constexpr int flight_sums = sizeof(FlightSums) / sizeof(double);

/// The sums of the flights in the lanes of T.
template <class T, int N> class FlightMetrics {
  public:
    /// The model's rotors tell how much energy their spinning holds, the plant's how much drag costs.
    explicit FlightMetrics(const Vehicle<T, N>& model) : spin_inertia_(model.spin_inertia) {}

    /// Add the row that the flight has come to; for a vehicle whose flight is over, nothing.
    void add(const Flight<T, N>& flight, const Desired<T>& now) {
        const Plant<T, N>& plant = flight.plant;
        counts_ = counts_ & (flight.flying() & is_finite(sum_of(plant)));
        rows_ += counted(T(1));
        add_errors(plant.motion, now, flight.time_left() < last_second);
        add_rotors(plant, flight.step == 0);
        const int m = plant.settings().vehicle.n_servos;
        for (int j = 0; j < m; ++j) {
            const T tilt = plant.actuators.tilt[j];
            tilt_.add(counted(tilt));
            tilt_max_ = select(counts_ & (tilt > tilt_max_), tilt, tilt_max_);
            tilt_min_ = select(counts_ & (tilt < tilt_min_), tilt, tilt_min_);
        }
        const Allocation<T, N>& decided = flight.decided();
        T bounds = T(0);
        for (int i = 0; i < plant.settings().vehicle.n_rotors; ++i) bounds += abs(decided.active[i]);
        saturated_ += counted(select(bounds > T(0), T(1), T(0)));
        kkt_residual_max_ = select(counts_, max_or_nan(kkt_residual_max_, decided.kkt_residual), kkt_residual_max_);
        if (flight.control_is_due()) unproven_ += counted(select(decided.kkt_residual > T(box_qp::proven<T>), T(1), T(0)));
    }

    FlightSums of(int vehicle) const {
        const auto number = [&](const T& x) { return double(lane(x, vehicle)); };
        return {number(rows_),           number(distance_.value()), number(distance_squared_.value()), number(distance_max_),
                number(angle_.value()),  number(angle_squared_.value()), number(angle_max_),           number(sine_.value()),
                number(drag_power_.value()), number(energy_gained_.value()), number(tilt_.value()),    number(tilt_min_),
                number(tilt_max_),       number(saturated_),        number(speed_max_),                number(kkt_residual_max_),
                number(unproven_),       number(last_rows_),        number(last_distance_.value()),    number(last_angle_.value())};
    }

  private:
    /// Not finite if one of the numbers is not.
    static T sum_of(const Plant<T, N>& plant) {
        T sum = T(0);
        for (int r = 0; r < 3; ++r) {
            sum += plant.motion.p[r];
            for (int c = 0; c < 3; ++c) sum += plant.motion.R[r][c];
        }
        for (int i = 0; i < plant.settings().vehicle.n_rotors; ++i) sum += plant.actuators.speed[i];
        for (int j = 0; j < plant.settings().vehicle.n_servos; ++j) sum += plant.actuators.tilt[j];
        return sum;
    }

    void add_errors(const Motion<T>& motion, const Desired<T>& now, bool is_last) {
        const Vec3<T> e_p = motion.p - now.p;
        const T distance_squared = dot(e_p, e_p), distance = sqrt(distance_squared);
        const Mat3<T> R_error = transpose_times(motion.R, now.R);
        const Vec3<T> e_R = vee_of_skew_part(R_error);
        const T sine = sqrt(dot(e_R, e_R)), cosine = T(0.5) * (R_error[0][0] + R_error[1][1] + R_error[2][2] - T(1));
        const T angle = atan2(sine, cosine);
        distance_.add(counted(distance));
        distance_squared_.add(counted(distance_squared));
        raise(distance_max_, distance);
        angle_.add(counted(angle));
        angle_squared_.add(counted(angle * angle));
        raise(angle_max_, angle);
        sine_.add(counted(sine));
        if (!is_last) return;
        last_rows_ += counted(T(1));
        last_distance_.add(counted(distance));
        last_angle_.add(counted(angle));
    }

    /// Drag over the step that ended here; the energy that it took to spin up, of which slowing down gives nothing back.
    void add_rotors(const Plant<T, N>& plant, bool first) {
        T power = T(0), gained = T(0), fastest = T(0);
        for (int i = 0; i < plant.settings().vehicle.n_rotors; ++i) {
            const T speed = abs(plant.actuators.speed[i]), squared = speed * speed;
            if (!first) {
                power += plant.settings().vehicle.drag_coefficient[i] * (squared * speed);
                gained += T(0.5) * spin_inertia_[i] * max(squared - speed_squared_[i], T(0));
            }
            speed_squared_[i] = squared;
            fastest = max(fastest, speed);
        }
        drag_power_.add(counted(power));
        energy_gained_.add(counted(gained));
        raise(speed_max_, fastest);
    }

    T counted(const T& x) const { return select(counts_, x, T(0)); }
    void raise(T& largest, const T& x) const { largest = select(counts_ & (x > largest), x, largest); }

    PerRotor<T, N> spin_inertia_, speed_squared_{};
    Mask<T> counts_ = T(0) == T(0);
    T rows_ = T(0), saturated_ = T(0), unproven_ = T(0), last_rows_ = T(0);
    T distance_max_ = T(0), angle_max_ = T(0), speed_max_ = T(0), kkt_residual_max_ = T(0);
    T tilt_max_ = T(-1e30), tilt_min_ = T(1e30);  // beyond any servo
    CompensatedSum<T> distance_, distance_squared_, angle_, angle_squared_, sine_, drag_power_, energy_gained_, tilt_, last_distance_, last_angle_;
};

}  // namespace omnimorph
