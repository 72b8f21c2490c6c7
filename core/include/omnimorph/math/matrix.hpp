// Small vectors and matrices of fixed size, so that code reads like the mathematics.
#pragma once

#include "number.hpp"

namespace omnimorph {

template <class T, int R> struct Vec {
    T a[R];
    OMNIMORPH_FN T& operator[](int i) { return a[i]; }
    OMNIMORPH_FN const T& operator[](int i) const { return a[i]; }

    friend OMNIMORPH_FN Vec operator+(const Vec& x, const Vec& y) {
        Vec z;
        for (int i = 0; i < R; ++i) z[i] = x[i] + y[i];
        return z;
    }
    friend OMNIMORPH_FN Vec operator-(const Vec& x, const Vec& y) {
        Vec z;
        for (int i = 0; i < R; ++i) z[i] = x[i] - y[i];
        return z;
    }
    friend OMNIMORPH_FN Vec operator*(const T& s, const Vec& x) {
        Vec z;
        for (int i = 0; i < R; ++i) z[i] = s * x[i];
        return z;
    }
    friend OMNIMORPH_FN T dot(const Vec& x, const Vec& y) {
        T sum = x[0] * y[0];
        for (int i = 1; i < R; ++i) sum += x[i] * y[i];
        return sum;
    }
    OMNIMORPH_FN static Vec zero() {
        Vec z;
        for (int i = 0; i < R; ++i) z[i] = T(0);
        return z;
    }
};

template <class T> using Vec3 = Vec<T, 3>;
template <class T> using Vec6 = Vec<T, 6>;

template <class T> OMNIMORPH_FN Vec3<T> cross(const Vec3<T>& x, const Vec3<T>& y) {
    return {{x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]}};
}

/// 3 x 3 matrix, row by row.
template <class T> struct Mat3 {
    T a[3][3];
    OMNIMORPH_FN T* operator[](int row) { return a[row]; }
    OMNIMORPH_FN const T* operator[](int row) const { return a[row]; }

    OMNIMORPH_FN static Mat3 identity() { return {{{T(1), T(0), T(0)}, {T(0), T(1), T(0)}, {T(0), T(0), T(1)}}}; }
};

template <class T> OMNIMORPH_FN Vec3<T> operator*(const Mat3<T>& M, const Vec3<T>& x) {
    Vec3<T> y;
    for (int i = 0; i < 3; ++i) y[i] = M[i][0] * x[0] + M[i][1] * x[1] + M[i][2] * x[2];
    return y;
}
/// Mᵀ x
template <class T> OMNIMORPH_FN Vec3<T> transpose_times(const Mat3<T>& M, const Vec3<T>& x) {
    Vec3<T> y;
    for (int i = 0; i < 3; ++i) y[i] = M[0][i] * x[0] + M[1][i] * x[1] + M[2][i] * x[2];
    return y;
}
template <class T> OMNIMORPH_FN Mat3<T> operator*(const Mat3<T>& M, const Mat3<T>& K) {
    Mat3<T> P;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) P[i][j] = M[i][0] * K[0][j] + M[i][1] * K[1][j] + M[i][2] * K[2][j];
    return P;
}
/// Mᵀ K
template <class T> OMNIMORPH_FN Mat3<T> transpose_times(const Mat3<T>& M, const Mat3<T>& K) {
    Mat3<T> P;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) P[i][j] = M[0][i] * K[0][j] + M[1][i] * K[1][j] + M[2][i] * K[2][j];
    return P;
}
/// M⁻¹ by cofactors; M must be regular.
template <class T> OMNIMORPH_FN Mat3<T> inverse(const Mat3<T>& M) {
    Mat3<T> C;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            const int r = (j + 1) % 3, s = (j + 2) % 3, c = (i + 1) % 3, d = (i + 2) % 3;
            C[i][j] = M[r][c] * M[s][d] - M[r][d] * M[s][c];
        }
    const T determinant = M[0][0] * C[0][0] + M[0][1] * C[1][0] + M[0][2] * C[2][0];
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) C[i][j] = C[i][j] / determinant;
    return C;
}

// The same value in another number type.
template <class T, class S, int R> OMNIMORPH_FN Vec<T, R> cast(const Vec<S, R>& x) {
    Vec<T, R> y;
    for (int i = 0; i < R; ++i) y[i] = T(x[i]);
    return y;
}
template <class T, class S> OMNIMORPH_FN Mat3<T> cast(const Mat3<S>& M) {
    Mat3<T> K;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) K[i][j] = T(M[i][j]);
    return K;
}

}  // namespace omnimorph
