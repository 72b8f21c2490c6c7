// What is recorded of a flight: one column a line.
#pragma once

#include "loop.hpp"

namespace omnimorph {

/// What a row shows: the state, what was decided in it, where it should be, and the thrusts.
template <class T, int N> struct Row {
    const FlightState<T, N>& x;
    const Desired<T>& desired;
    PerRotor<T, N> thrust_actual;
};

inline constexpr int per_rotor = -1, per_servo = -2;  // instead of a number, in the shape of a column

/// Its name, the shape of a row of it (up to two numbers; 0 for none), how it is stored, and where its numbers are.
template <class Stored, class Values> struct Column {
    using Number = Stored;
    const char* name;
    int shape[2];
    Values values;

    constexpr int width(int n, int m) const {
        int product = 1;
        for (const int extent : shape) product *= extent == per_rotor ? n : extent == per_servo ? m : extent == 0 ? 1 : extent;
        return product;
    }
};
template <class Stored = double, class Values> constexpr auto column(const char* name, int rows, int columns, Values values) {
    return Column<Stored, Values>{name, {rows, columns}, values};
}

template <class T, int N> constexpr auto columns() {
    using R = Row<T, N>;
    return std::make_tuple(
        column("p_WB", 3, 0, [](const R& row) { return row.x.plant.motion.p.a; }),
        column("R_WB", 3, 3, [](const R& row) { return row.x.plant.motion.R.a[0]; }),
        column("v_WB", 3, 0, [](const R& row) { return row.x.plant.motion.v.a; }),
        column("w_WB_B", 3, 0, [](const R& row) { return row.x.plant.motion.w.a; }),
        column("desired_p_WB", 3, 0, [](const R& row) { return row.desired.p.a; }),
        column("desired_R_WB", 3, 3, [](const R& row) { return row.desired.R.a[0]; }),
        column("desired_v_WB", 3, 0, [](const R& row) { return row.desired.v.a; }),
        column("desired_w_WB_B", 3, 0, [](const R& row) { return row.desired.w.a; }),
        column("thrust_command", per_rotor, 0, [](const R& row) { return row.x.decided.command.thrust.a; }),
        column("thrust_actual", per_rotor, 0, [](const R& row) { return row.thrust_actual.a; }),
        column("speed", per_rotor, 0, [](const R& row) { return row.x.plant.actuators.speed.a; }),
        column("tilt_command", per_servo, 0, [](const R& row) { return row.x.decided.command.tilt.a; }),
        column("tilt_actual", per_servo, 0, [](const R& row) { return row.x.plant.actuators.tilt.a; }),
        column("wrench_asked", 6, 0, [](const R& row) { return row.x.decided.wrench_asked.a; }),
        column("wrench_achieved", 6, 0, [](const R& row) { return row.x.plant.load.wrench.a; }),
        column("cost", 0, 0, [](const R& row) { return &row.x.decided.cost; }),
        column("kkt_residual", 0, 0, [](const R& row) { return &row.x.decided.kkt_residual; }),
        column<std::int8_t>("active", per_rotor, 0, [](const R& row) { return row.x.decided.active.a; }));
}
inline constexpr int n_columns = std::tuple_size_v<decltype(columns<double, 1>())>;

/// Where the rows of a flight go, column by column: plain arrays of the caller, row after row, or nowhere (null).
struct Record {
    void* column[n_columns] = {};
    bool is_kept() const { return column[0] != nullptr; }
};

/// Write one lane of a row, number `index` of the flight.
template <class T, int N> void write_row(const Row<T, N>& row, int n, int m, int lane_number, long index, const Record& record) {
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

}  // namespace omnimorph
