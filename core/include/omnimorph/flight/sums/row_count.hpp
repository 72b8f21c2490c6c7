// How many rows count.
#pragma once

#include "summed_row.hpp"

namespace omnimorph {

template <class T> struct RowCount {
    T rows = T(0);       // from the first to the last whose numbers are all finite
    T last_rows = T(0);  // of the last second

    static constexpr auto fields() {
        return field_list(field("rows", &RowCount::rows), field("last_rows", &RowCount::last_rows));
    }

    template <int N> OMNIMORPH_FN void add(const SummedRow<T, N>& row) {
        rows += row.counted(T(1));
        if (row.is_in_last_second) last_rows += row.counted(T(1));
    }
};

}  // namespace omnimorph
