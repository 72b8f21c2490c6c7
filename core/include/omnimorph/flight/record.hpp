// What is recorded of a flight: one column a line.
#pragma once

#include <tuple>

#include "loop.hpp"

namespace omnimorph {

/// What a row shows: the state, the decision in it, the desired motion, and the thrusts.
template <class T, int N> struct Row {
    const FlightState<T, N>& x;
    const Desired<T>& desired;
    PerRotor<T, N> thrust_actual;
};

inline constexpr int per_rotor = -1, per_servo = -2;  // instead of a number, in the shape of a column

/// Its name, the shape of a row of it (up to two extents; 0 for none), how it is stored, and where its numbers are.
template <int Rows, int Columns, class Stored, class Values> struct Column {
    using Number = Stored;
    static constexpr int shape[2] = {Rows, Columns};
    const char* name;
    Values values;

    /// How many numbers a row has; a constant, where the counts are.
    template <int N> static constexpr int width(Count<N> n, int m) {
        return extent(Rows, n, m) * extent(Columns, n, m);
    }

  private:
    static constexpr int extent(int in_shape, int n, int m) {
        return in_shape == per_rotor ? n : in_shape == per_servo ? m : in_shape == 0 ? 1 : in_shape;
    }
};
template <int Rows = 0, int Columns = 0, class Stored = double, class Values>
constexpr auto column(const char* name, Values values) {
    return Column<Rows, Columns, Stored, Values>{name, values};
}

template <class T, int N> constexpr auto columns() {
    using R = Row<T, N>;
    return std::make_tuple(
        column<3>("p_WB", [](const R& row) { return row.x.plant.motion.p.a; }),
        column<3, 3>("R_WB", [](const R& row) { return row.x.plant.motion.R.a[0]; }),
        column<3>("v_WB", [](const R& row) { return row.x.plant.motion.v.a; }),
        column<3>("w_WB_B", [](const R& row) { return row.x.plant.motion.w.a; }),
        column<3>("desired_p_WB", [](const R& row) { return row.desired.p.a; }),
        column<3, 3>("desired_R_WB", [](const R& row) { return row.desired.R.a[0]; }),
        column<3>("desired_v_WB", [](const R& row) { return row.desired.v.a; }),
        column<3>("desired_w_WB_B", [](const R& row) { return row.desired.w.a; }),
        column<per_rotor>("thrust_command", [](const R& row) { return row.x.decided.command.thrust.a; }),
        column<per_rotor>("thrust_actual", [](const R& row) { return row.thrust_actual.a; }),
        column<per_rotor>("speed", [](const R& row) { return row.x.plant.actuators.speed.a; }),
        column<per_servo>("tilt_command", [](const R& row) { return row.x.decided.command.tilt.a; }),
        column<per_servo>("tilt_actual", [](const R& row) { return row.x.plant.actuators.tilt.a; }),
        column<6>("wrench_asked", [](const R& row) { return row.x.decided.wrench_asked.a; }),
        column<6>("wrench_achieved", [](const R& row) { return row.x.plant.load.wrench.a; }),
        column("cost", [](const R& row) { return &row.x.decided.cost; }),
        column("kkt_residual", [](const R& row) { return &row.x.decided.kkt_residual; }),
        column<per_rotor, 0, std::int8_t>("active", [](const R& row) { return row.x.decided.active.a; }));
}
inline constexpr int n_columns = std::tuple_size_v<decltype(columns<double, 1>())>;

/// Where the rows of a flight go, column by column: plain arrays of the caller, row after row, or nowhere (null).
struct Record {
    void* column[n_columns] = {};
    bool is_kept() const { return column[0] != nullptr; }
};

/// Write one lane of a row, number `index` of the flight.
template <class T, int N>
void write_row(const Row<T, N>& row, Count<N> n, int m, int lane_number, long index, const Record& record) {
    int k = 0;
    const auto write = [&](const auto& column) {
        using Number = typename std::decay_t<decltype(column)>::Number;
        const int width = column.width(n, m);
        const T* values = column.values(row);
        Number* to = static_cast<Number*>(record.column[k++]) + index * width;
        for (int c = 0; c < width; ++c) to[c] = static_cast<Number>(lane(values[c], lane_number));
    };
    std::apply([&](const auto&... column) { (write(column), ...); }, columns<T, N>());
}

/// Fill the state and the desired motion of a row from a record of one flight; not a number, where a column is not
/// kept.
template <int N> void read_row(const Record& record, Count<N> n, int m, long index, Row<double, N>& row) {
    int k = 0;
    const auto read = [&](const auto& column) {
        using Number = typename std::decay_t<decltype(column)>::Number;
        const int width = column.width(n, m);
        const auto* from = static_cast<const Number*>(record.column[k++]);
        auto* to = const_cast<double*>(column.values(row));  // of what the row shows, which is the caller's
        for (int c = 0; c < width; ++c)
            to[c] = from == nullptr ? std::nan("") : static_cast<double>(from[index * width + c]);
    };
    std::apply([&](const auto&... column) { (read(column), ...); }, columns<double, N>());
}

}  // namespace omnimorph
