// Between the arrays of a flight in Python and what the core makes of them: commands, and the columns of a record.
#pragma once

#include "arrays.hpp"
#include "loop.hpp"

namespace omnimorph::python {

inline AnyCommand command_from(const Array& thrust, const Array& tilt, int n, int m) {
    return {per_rotor_from(thrust, n, "thrust"), per_servo_from(tilt, m, "tilt")};
}

inline double* column(const nb::dict& columns, const char* name, std::size_t size) {
    const auto array = nb::cast<nb::ndarray<double, nb::c_contig, nb::device::cpu>>(columns[name], false);  // no copy
    if (array.size() != size) throw nb::value_error((std::string("column ") + name + " has the wrong size").c_str());
    return array.data();
}

/// The columns of a run with so many rows; nowhere, if there are none.
inline Record record_into(const nb::dict& columns, std::size_t rows, std::size_t n, std::size_t m) {
    Record r;
    if (columns.size() == 0) return r;
    r.p = column(columns, "p_WB", 3 * rows);
    r.R = column(columns, "R_WB", 9 * rows);
    r.v = column(columns, "v_WB", 3 * rows);
    r.w = column(columns, "w_WB_B", 3 * rows);
    r.desired_p = column(columns, "desired_p_WB", 3 * rows);
    r.desired_R = column(columns, "desired_R_WB", 9 * rows);
    r.desired_v = column(columns, "desired_v_WB", 3 * rows);
    r.desired_w = column(columns, "desired_w_WB_B", 3 * rows);
    r.thrust = column(columns, "thrust", n * rows);
    r.speed = column(columns, "speed", n * rows);
    r.tilt = column(columns, "tilt", m * rows);
    r.tilt_command = column(columns, "tilt_command", m * rows);
    r.wrench_asked = column(columns, "wrench_asked", 6 * rows);
    r.wrench_achieved = column(columns, "wrench_achieved", 6 * rows);
    r.cost = column(columns, "cost", rows);
    r.kkt_residual = column(columns, "kkt_residual", rows);
    const auto active = nb::cast<nb::ndarray<std::int8_t, nb::c_contig, nb::device::cpu>>(columns["active"], false);
    if (active.size() != n * rows) throw nb::value_error("column active has the wrong size");
    r.active = active.data();
    return r;
}

}  // namespace omnimorph::python
