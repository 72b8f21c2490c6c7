// Between NumPy arrays and the core's vectors.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <vector>

#include "omnimorph/flight/flight.hpp"

namespace omnimorph::python {

namespace nb = nanobind;

using Array = nb::ndarray<const double, nb::c_contig, nb::device::cpu>;
using Numbers = nb::ndarray<nb::numpy, double>;

inline constexpr int state_width = 18, desired_width = 24;  // p R v w; and a dw

inline void expect_size(const Array& array, std::size_t size, const char* name) {
    if (array.size() != size)
        throw nb::value_error(
            (std::string(name) + " has " + std::to_string(array.size()) + " numbers, not " + std::to_string(size))
                .c_str());
}

/// A new NumPy array of the given shape holding a copy of `values`.
inline Numbers new_array(const double* values, std::vector<std::size_t> shape) {
    std::size_t size = 1;
    for (const std::size_t extent : shape) size *= extent;
    double* copy = new double[size];
    for (std::size_t k = 0; k < size; ++k) copy[k] = values[k];
    const nb::capsule owner(copy, [](void* p) noexcept { delete[] static_cast<double*>(p); });
    return Numbers(copy, shape.size(), shape.data(), owner);
}

/// Numbers that live in the object whose property they are, and which the array keeps alive; read-only.
inline nb::ndarray<nb::numpy, const double, nb::ndim<1>> view_of(const double* values, int size) {
    return {values, {static_cast<std::size_t>(size)}};
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

}  // namespace omnimorph::python
