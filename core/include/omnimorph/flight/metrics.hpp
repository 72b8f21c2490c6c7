// What flights are judged by, added up row by row while they fly: `omnimorph.results.metrics` says what each number
// means and makes the metrics of these sums, by their names.
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
    explicit FlightMetrics(const Vehicle<T, N>& model) : model_(model) {}

    const FlightSums<T>& sums() const { return sums_; }

    /// Add the row that the flight has come to; for a vehicle whose flight is over, nothing.
    OMNIMORPH_FN void add(const Flight<T, N>& flight, const Desired<T>& now) {
        const FlightState<T, N>& x = flight.state();
        const Vehicle<T, N>& truth = flight.loop().plant.settings.vehicle;
        counts_ = counts_ & (flight.flying() & is_finite(sum_of(x.plant, truth)));
        const SummedRow<T, N> row{
            x,      now, model_, truth, before_, x.step == 0, flight.time_left() < last_second, flight.control_is_due(),
            counts_};
        for_each(sums_, [&](auto& each) { each.add(row); });
        before_ = x.plant.actuators;
    }

  private:
    /// Not finite if one of the numbers is not.
    OMNIMORPH_FN static T sum_of(const PlantState<T, N>& plant, const Vehicle<T, N>& truth) {
        T sum = T(0);
        for (int r = 0; r < 3; ++r) {
            sum += plant.motion.p[r];
            for (int c = 0; c < 3; ++c) sum += plant.motion.R[r][c];
        }
        for (int i = 0; i < truth.n_rotors; ++i) sum += plant.actuators.speed[i];
        for (int j = 0; j < truth.n_servos; ++j) sum += plant.actuators.tilt[j];
        return sum;
    }

    FlightSums<T> sums_;
    const Vehicle<T, N>& model_;
    Actuators<T, N> before_{};
    Mask<T> counts_ = T(0) == T(0);
};

}  // namespace omnimorph
