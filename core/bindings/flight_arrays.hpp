// Between the arrays of a flight in Python and what the core makes of them: commands, and the columns of a record.
#pragma once

#include <initializer_list>
#include <memory>

#include "arrays.hpp"
#include "loop.hpp"

namespace omnimorph::python {

inline AnyCommand command_from(const Array& thrust, const Array& tilt, int n, int m) {
    return {per_rotor_from(thrust, n, "thrust"), per_servo_from(tilt, m, "tilt")};
}

/// Refuse a flight whose rows cannot be counted: its columns have one for each physics step and one more.
inline void expect_times(long steps, int control_every, bool is_recorded) {
    constexpr long most_recorded = 1L << 31;
    if (steps < 0 || control_every < 1) throw nb::value_error("a flight has steps, and at least one between two commands");
    if (is_recorded && steps > most_recorded) throw nb::value_error("a flight that is recorded has at most 2^31 steps");
}

/// The columns of a run. A flight writes into them through plain pointers, so they belong to it and not to Python, which
/// gets arrays that it can read and that keep them alive.
class Columns {
  public:
    Columns(std::size_t rows, int n, int m)
        : rows_(rows), n_(static_cast<std::size_t>(n)), m_(static_cast<std::size_t>(m)), active_(new std::int8_t[rows * n_]) {
        for (const Column& column : all()) numbers_.emplace_back(new double[rows * width(column)]);
    }

    Record record() const {
        Record r;
        for (std::size_t k = 0; k < numbers_.size(); ++k) r.*all()[k].place = numbers_[k].get();
        r.active = active_.get();
        return r;
    }

    /// Read-only arrays, by name.
    static nb::dict arrays(const std::shared_ptr<const Columns>& columns) {
        const nb::capsule owner(new std::shared_ptr<const Columns>(columns),
                                [](void* p) noexcept { delete static_cast<std::shared_ptr<const Columns>*>(p); });
        nb::dict out;
        for (std::size_t k = 0; k < columns->numbers_.size(); ++k)
            out[all()[k].name] = columns->array<double>(columns->numbers_[k].get(), all()[k].shape, owner);
        out["active"] = columns->array<std::int8_t>(columns->active_.get(), {per_rotor}, owner);
        return out;
    }

  private:
    enum : std::size_t { per_rotor = 1000, per_servo };  // instead of a number, in a shape

    struct Column {
        const char* name;
        double* Record::*place;
        std::vector<std::size_t> shape;  // of a row
    };

    static const std::vector<Column>& all() {
        static const std::vector<Column> columns{
            {"p_WB", &Record::p, {3}},
            {"R_WB", &Record::R, {3, 3}},
            {"v_WB", &Record::v, {3}},
            {"w_WB_B", &Record::w, {3}},
            {"desired_p_WB", &Record::desired_p, {3}},
            {"desired_R_WB", &Record::desired_R, {3, 3}},
            {"desired_v_WB", &Record::desired_v, {3}},
            {"desired_w_WB_B", &Record::desired_w, {3}},
            {"thrust_command", &Record::thrust_command, {per_rotor}},
            {"thrust_actual", &Record::thrust_actual, {per_rotor}},
            {"speed", &Record::speed, {per_rotor}},
            {"tilt_command", &Record::tilt_command, {per_servo}},
            {"tilt_actual", &Record::tilt_actual, {per_servo}},
            {"wrench_asked", &Record::wrench_asked, {6}},
            {"wrench_achieved", &Record::wrench_achieved, {6}},
            {"cost", &Record::cost, {}},
            {"kkt_residual", &Record::kkt_residual, {}},
        };
        return columns;
    }

    std::size_t extent(std::size_t in_shape) const { return in_shape == per_rotor ? n_ : in_shape == per_servo ? m_ : in_shape; }
    std::size_t width(const Column& column) const {
        std::size_t numbers = 1;
        for (const std::size_t in_shape : column.shape) numbers *= extent(in_shape);
        return numbers;
    }

    template <class S> nb::object array(const S* values, const std::vector<std::size_t>& row, const nb::capsule& owner) const {
        std::vector<std::size_t> shape{rows_};
        for (const std::size_t in_shape : row) shape.push_back(extent(in_shape));
        return nb::cast(nb::ndarray<nb::numpy, const S>(values, shape.size(), shape.data(), owner));
    }

    std::size_t rows_, n_, m_;
    std::vector<std::unique_ptr<double[]>> numbers_;  // not yet written, and so not yet taken from the machine
    std::unique_ptr<std::int8_t[]> active_;
};

}  // namespace omnimorph::python
