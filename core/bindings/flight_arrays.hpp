// Between the arrays of a flight in Python and what the core makes of them: commands, and the columns of a record.
#pragma once

#include <limits>
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
    if (steps < 0 || control_every < 1)
        throw nb::value_error("a flight has steps, and at least one between two commands");
    if (is_recorded && steps > most_recorded) throw nb::value_error("a flight that is recorded has at most 2^31 steps");
}

/// The columns of a run. A flight writes into them through plain pointers, so they belong to it and not to Python,
/// which gets arrays that it can read and that keep them alive.
class RunColumns {
  public:
    RunColumns(std::size_t rows, int n, int m) : rows_(rows), n_(n), m_(m) {
        const auto add = [&](const auto& column) {
            using Number = typename std::decay_t<decltype(column)>::Number;
            const std::size_t bytes = rows * static_cast<std::size_t>(column.width(Count<0>(n), m)) * sizeof(Number);
            numbers_.emplace_back(new unsigned char[bytes + 1]);  // some vehicles have no servo
        };
        std::apply([&](const auto&... column) { (add(column), ...); }, columns<double, 0>());
    }

    Record record() const {
        Record r;
        for (std::size_t k = 0; k < numbers_.size(); ++k) r.column[k] = numbers_[k].get();
        return r;
    }

    /// Rows that nobody flew: not a number, and no bound active.
    void leave_out(long first, long last) {
        std::size_t k = 0;
        const auto fill = [&](const auto& column) {
            using Number = typename std::decay_t<decltype(column)>::Number;
            const long width = column.width(Count<0>(n_), m_);
            auto* numbers = reinterpret_cast<Number*>(numbers_[k++].get());
            std::fill(numbers + first * width, numbers + std::max(first, last) * width,
                      std::numeric_limits<Number>::quiet_NaN());
        };
        std::apply([&](const auto&... column) { (fill(column), ...); }, columns<double, 0>());
    }

    /// The first rows of each column, from arrays by name of the type and width of the columns.
    void put(const nb::dict& arrays) {
        std::size_t k = 0;
        const auto put = [&](const auto& column) {
            using Number = typename std::decay_t<decltype(column)>::Number;
            using Given = nb::ndarray<const Number, nb::c_contig, nb::device::cpu>;
            const Given given = nb::cast<Given>(arrays[column.name]);
            const std::size_t all = rows_ * static_cast<std::size_t>(column.width(Count<0>(n_), m_));
            if (given.size() > all) throw nb::value_error("a column has more rows than the flight");
            std::copy_n(given.data(), given.size(), reinterpret_cast<Number*>(numbers_[k++].get()));
        };
        std::apply([&](const auto&... column) { (put(column), ...); }, columns<double, 0>());
    }

    /// Read-only arrays, by name.
    static nb::dict arrays(const std::shared_ptr<const RunColumns>& run) {
        const nb::capsule owner(new std::shared_ptr<const RunColumns>(run),
                                [](void* p) noexcept { delete static_cast<std::shared_ptr<const RunColumns>*>(p); });
        nb::dict out;
        std::size_t k = 0;
        const auto add = [&](const auto& column) {
            using Number = typename std::decay_t<decltype(column)>::Number;
            std::vector<std::size_t> shape{run->rows_};
            for (const int extent : column.shape)
                if (extent != 0)
                    shape.push_back(static_cast<std::size_t>(extent == per_rotor   ? run->n_
                                                             : extent == per_servo ? run->m_
                                                                                   : extent));
            const auto* numbers = reinterpret_cast<const Number*>(run->numbers_[k++].get());
            out[column.name] = nb::ndarray<nb::numpy, const Number>(numbers, shape.size(), shape.data(), owner);
        };
        std::apply([&](const auto&... column) { (add(column), ...); }, columns<double, 0>());
        return out;
    }

  private:
    std::size_t rows_;
    int n_, m_;
    std::vector<std::unique_ptr<unsigned char[]>> numbers_;  // not yet written, and so not yet taken from the machine
};

/// A record that shows the columns of a dict; those that it lacks are not kept.
inline Record record_from(const nb::dict& arrays, std::size_t rows, int n, int m) {
    Record r;
    std::size_t k = 0;
    const auto take = [&](const auto& column) {
        using Number = typename std::decay_t<decltype(column)>::Number;
        void*& place = r.column[k++];
        if (!arrays.contains(column.name)) return;
        const auto array =
            nb::cast<nb::ndarray<const Number, nb::c_contig, nb::device::cpu>>(arrays[column.name], false);
        if (array.size() != rows * static_cast<std::size_t>(column.width(Count<0>(n), m)))
            throw nb::value_error((std::string(column.name) + " does not have its size").c_str());
        place = const_cast<Number*>(array.data());  // and is only read
    };
    std::apply([&](const auto&... column) { (take(column), ...); }, columns<double, 0>());
    return r;
}

}  // namespace omnimorph::python
