// What flights are judged by, added up row by row, while they fly or from their records: `omnimorph.results.metrics`
// says what each number means and makes the metrics of these sums, by their names.
#pragma once

#include "flight.hpp"
#include "sums/allocation_proofs.hpp"
#include "sums/attitude_error.hpp"
#include "sums/position_error.hpp"
#include "sums/rotor_energy.hpp"
#include "sums/row_count.hpp"
#include "sums/tilts.hpp"

namespace omnimorph {
template <class T>
using FlightSums =
    Records<AllocationProofs<T>, AttitudeError<T>, PositionError<T>, RotorEnergy<T>, RowCount<T>, Tilts<T>>;

/// visit(name, sum) for every sum.
template <class Sums, class Visit> void for_each_sum(const Sums& sums, Visit&& visit) {
    const auto name_and_sum = [&](const auto& field, const auto& sum) { visit(field.name, sum); };
    for_each(sums, [&](const auto& each) { for_each_field(each, name_and_sum); });
}

template <class... Each> constexpr int number_of_sums(const Records<Each...>*) {
    return static_cast<int>((fields::count<Each>() + ...));
}
inline constexpr int n_flight_sums = number_of_sums(static_cast<const FlightSums<double>*>(nullptr));

/// The sums of one lane, in the order in which `for_each_sum` names them.
template <class T> void write_sums(const FlightSums<T>& sums, int lane_number, double* to) {
    for_each_sum(sums, [&](const char*, const auto& sum) { *to++ = double(lane(static_cast<T>(sum), lane_number)); });
}

inline constexpr double last_second = 1.0;

/// The sums of the flights in the lanes of T; the vehicle as the controller knows it must outlive them.
template <class T, int N> class FlightMetrics {
  public:
    /// An allocation whose residual is not larger than `proof` proves itself.
    explicit FlightMetrics(const Vehicle<T, N>& model, double proof = box_qp::proven<T>)
        : model_(model), proof_(T(proof)) {}

    const FlightSums<T>& sums() const { return sums_; }

    /// Add the row that the flight has come to; for a vehicle whose flight is over, nothing.
    OMNIMORPH_FN void add(const Flight<T, N>& flight, const Desired<T>& now) {
        const Vehicle<T, N>& truth = flight.loop().plant.settings.vehicle;
        const PerRotor<T, N>& speed = flight.state().plant.actuators.speed;
        T drag_power = T(0);
        for (int i = 0; i < truth.n_rotors; ++i) {
            const T size = abs(speed[i]);
            drag_power += truth.drag_coefficient[i] * (size * size * size);
        }
        add(flight.state(), now, drag_power, flight.time_left() < last_second, flight.control_is_due(),
            flight.flying());
    }

    /// Add row `x.step` of flights; see `SummedRow`.
    OMNIMORPH_FN void add(const FlightState<T, N>& x, const Desired<T>& now, const T& drag_power,
                          bool is_in_last_second, bool is_decided, const Mask<T>& flying) {
        const Actuators<T, N>& actuators = x.plant.actuators;
        counts_ = counts_ & (flying & are_finite(x.plant.motion, actuators, now));
        const SummedRow<T, N> row{
            x, now, model_, before_, drag_power, proof_, x.step == 0, is_in_last_second, is_decided, counts_};
        for_each(sums_, [&](auto& each) { each.add(row); });
        for (int i = 0; i < model_.n_rotors; ++i) before_.speed[i] = actuators.speed[i];
        for (int j = 0; j < model_.n_servos; ++j) before_.tilt[j] = actuators.tilt[j];
    }

  private:
    OMNIMORPH_FN Mask<T> are_finite(const Motion<T>& motion, const Actuators<T, N>& actuators,
                                    const Desired<T>& now) const {
        T sum = T(0);  // of zeros, unless one of the numbers is not finite
        for (int r = 0; r < 3; ++r) {
            sum += T(0) * motion.p[r] + T(0) * now.p[r];
            for (int c = 0; c < 3; ++c) sum += T(0) * motion.R[r][c] + T(0) * now.R[r][c];
        }
        for (int i = 0; i < model_.n_rotors; ++i) sum += T(0) * actuators.speed[i];
        for (int j = 0; j < model_.n_servos; ++j) sum += T(0) * actuators.tilt[j];
        return is_finite(sum);
    }

    FlightSums<T> sums_;
    const Vehicle<T, N>& model_;
    T proof_;
    Actuators<T, N> before_{};
    Mask<T> counts_ = T(0) == T(0);
};

/// A flight that is over, as it was recorded.
struct RecordedRows {
    Record record;
    const double* drag_power;  // W, one a row
    long rows;
    bool is_completed;  // else there is no last second, and the last row decided something, too
    double step;        // of physics, s
    int control_every;  // physics steps
    double proof;       // see `SummedRow`
};

/// The sums over the rows of a record.
template <int N> FlightSums<double> sums_of(const RecordedRows& recorded, const Vehicle<double, N>& model) {
    FlightMetrics<double, N> metrics(model, recorded.proof);
    FlightState<double, N> x{};
    Desired<double> now{};
    Row<double, N> row{x, now, {}};
    for (; x.step < recorded.rows; ++x.step) {
        read_row(recorded.record, Count<N>(model.n_rotors), model.n_servos, x.step, row);
        const long left = recorded.rows - 1 - x.step;
        const bool is_in_last_second = recorded.is_completed && double(left) * recorded.step < last_second;
        const bool is_decided = x.step % recorded.control_every == 0 && (left > 0 || !recorded.is_completed);
        metrics.add(x, now, recorded.drag_power[x.step], is_in_last_second, is_decided, true);
    }
    return metrics.sums();
}

}  // namespace omnimorph
