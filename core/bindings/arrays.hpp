// Between NumPy arrays and the core's vectors.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <initializer_list>
#include <vector>

#include "omnimorph/flight/flight.hpp"

namespace omnimorph::python {

namespace nb = nanobind;

using Array = nb::ndarray<const double, nb::c_contig, nb::device::cpu>;

/// An array of NumPy, in float64 and C order.
struct Numbers : nb::object {
    NB_OBJECT_DEFAULT(Numbers, nb::object, "numpy.ndarray[dtype=float64]", PyObject_CheckBuffer)
};

/// The memory of an object in C order, for as long as this lives. (An nb::ndarray, which makes a capsule, takes many
/// times as long.)
class Memory {
  public:
    explicit Memory(nb::handle object) {
        is_held_ = PyObject_GetBuffer(object.ptr(), &view_, PyBUF_FORMAT | PyBUF_C_CONTIGUOUS) == 0;
        if (!is_held_) PyErr_Clear();
    }
    Memory(const Memory&) = delete;
    Memory& operator=(const Memory&) = delete;
    ~Memory() {
        if (is_held_) PyBuffer_Release(&view_);
    }
    bool is_float64() const { return is_held_ && std::strcmp(view_.format, "d") == 0; }
    std::size_t size() const { return static_cast<std::size_t>(view_.len) / sizeof(double); }
    double* data() const { return static_cast<double*>(view_.buf); }

  private:
    Py_buffer view_{};
    bool is_held_;
};

inline constexpr int state_width = 18, desired_width = 24;  // p R v w; and a dw

inline void expect_size(std::size_t found, std::size_t size, const char* name) {
    if (found != size)
        throw nb::value_error(
            (std::string(name) + " has " + std::to_string(found) + " numbers, not " + std::to_string(size)).c_str());
}
inline void expect_size(const Array& array, std::size_t size, const char* name) {
    expect_size(array.size(), size, name);
}

/// numpy.empty, which is looked up once.
inline nb::handle numpy_empty() {
    static PyObject* empty = nullptr;
    if (empty == nullptr) empty = nb::object(nb::module_::import_("numpy").attr("empty")).release().ptr();
    return empty;
}

/// A new NumPy array of a given shape, a tuple or a single extent, holding a copy of `values`.
inline Numbers new_array_of(const double* values, nb::handle shape) {
    PyObject* array = PyObject_CallOneArg(numpy_empty().ptr(), shape.ptr());
    if (array == nullptr) throw nb::python_error();
    const Memory memory(array);
    std::copy_n(values, memory.size(), memory.data());
    return nb::steal<Numbers>(array);
}
inline Numbers new_array(const double* values, int size) {
    return new_array_of(values, nb::steal(PyLong_FromLong(size)));
}
inline Numbers new_array(const double* values, std::initializer_list<std::size_t> shape) {
    const nb::object extents = nb::steal(PyTuple_New(static_cast<Py_ssize_t>(shape.size())));
    Py_ssize_t k = 0;
    for (const std::size_t extent : shape) PyTuple_SET_ITEM(extents.ptr(), k++, PyLong_FromSize_t(extent));
    return new_array_of(values, extents);
}

/// New arrays of so many numbers, cut from blocks: NumPy cuts a row in half the time that a new array takes.
class Rows {
  public:
    explicit Rows(int width) : width_(width) {}

    Numbers next(const double* values) {
        if (left_ == 0) {
            left_ = rows_in_block;
            block_ = nb::borrow<Numbers>(numpy_empty()(nb::make_tuple(left_, width_)));
            data_ = Memory(block_).data();
        }
        --left_;
        std::copy_n(values, width_, data_ + left_ * width_);
        return nb::steal<Numbers>(PySequence_GetItem(block_.ptr(), left_));
    }

  private:
    static constexpr int rows_in_block = 64;
    int width_, left_ = 0;
    Numbers block_;
    double* data_ = nullptr;
};

/// So many numbers from an array of them, or from a tuple of arrays one after the other, as a State is. What is not
/// float64 in C order is refused: Python then makes a row of it.
template <int size> std::array<double, size> row_from(nb::handle given, const char* name) {
    std::array<double, size> row;
    std::size_t found = 0;
    const auto read = [&](nb::handle part) {
        const Memory memory(part);
        if (!memory.is_float64()) throw nb::type_error((std::string(name) + " is not in float64").c_str());
        if (found + memory.size() <= size) std::copy_n(memory.data(), memory.size(), row.data() + found);
        found += memory.size();
    };
    if (PyTuple_Check(given.ptr())) {
        for (Py_ssize_t k = 0; k < PyTuple_GET_SIZE(given.ptr()); ++k) read(PyTuple_GET_ITEM(given.ptr(), k));
    } else {
        read(given);
    }
    expect_size(found, size, name);
    return row;
}

template <int R> inline Vec<double, R> vector_from(const double* values) {
    Vec<double, R> x;
    for (int i = 0; i < R; ++i) x[i] = values[i];
    return x;
}
inline Mat3<double> matrix_from(const double* values) {
    Mat3<double> M;
    for (int i = 0; i < 9; ++i) M[i / 3][i % 3] = values[i];
    return M;
}
inline PerRotor<double, 0> per_rotor_from(const Array& array, int n, const char* name) {
    expect_size(array, static_cast<std::size_t>(n), name);
    PerRotor<double, 0> x{};
    for (int i = 0; i < n; ++i) x[i] = array.data()[i];
    return x;
}
inline PerRotor<Vec3<double>, 0> vector_per_rotor_from(const Array& array, int n, const char* name) {
    expect_size(array, static_cast<std::size_t>(3 * n), name);
    PerRotor<Vec3<double>, 0> x{};
    for (int i = 0; i < n; ++i) x[i] = vector_from<3>(array.data() + 3 * i);
    return x;
}
inline PerServo<double> per_servo_from(const Array& array, int m, const char* name) {
    expect_size(array, static_cast<std::size_t>(m), name);
    PerServo<double> x{};
    for (int j = 0; j < m; ++j) x[j] = array.data()[j];
    return x;
}
inline Motion<double> motion_from(const double* s) {
    return {vector_from<3>(s), vector_from<3>(s + 12), matrix_from(s + 3), vector_from<3>(s + 15)};
}
inline Motion<double> motion_from(const Array& array) {
    expect_size(array, state_width, "state");
    return motion_from(array.data());
}
inline Desired<double> desired_from(const double* d) {
    return {vector_from<3>(d),      vector_from<3>(d + 12), matrix_from(d + 3),
            vector_from<3>(d + 15), vector_from<3>(d + 18), vector_from<3>(d + 21)};
}
inline Desired<double> desired_from(const Array& array) {
    expect_size(array, desired_width, "desired");
    return desired_from(array.data());
}
/// The 18 numbers of a motion; returns where they end.
inline double* write(const Motion<double>& x, double* s) {
    for (int i = 0; i < 3; ++i) {
        s[i] = x.p[i], s[12 + i] = x.v[i], s[15 + i] = x.w[i];
        for (int j = 0; j < 3; ++j) s[3 + 3 * i + j] = x.R[i][j];
    }
    return s + state_width;
}
inline Numbers as_array(const Motion<double>& x) {
    double s[state_width];
    write(x, s);
    return new_array(s, {state_width});
}
inline Numbers as_array(const Desired<double>& x) {
    double s[desired_width];
    for (int i = 0; i < 3; ++i) {
        s[i] = x.p[i], s[12 + i] = x.v[i], s[15 + i] = x.w[i], s[18 + i] = x.a[i], s[21 + i] = x.dw[i];
        for (int j = 0; j < 3; ++j) s[3 + 3 * i + j] = x.R[i][j];
    }
    return new_array(s, {desired_width});
}
inline Motion<double> motion_from(nb::handle given) {
    return motion_from(row_from<state_width>(given, "state").data());
}
inline Desired<double> desired_from(nb::handle given) {
    return desired_from(row_from<desired_width>(given, "desired").data());
}

}  // namespace omnimorph::python
