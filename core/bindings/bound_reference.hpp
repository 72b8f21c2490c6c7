// A reference as Python holds it, with its tables.
#pragma once

#include "arrays.hpp"

namespace omnimorph::python {

struct BoundReference {
    std::vector<Segment> segments;
    std::vector<double> samples;

    Reference view() const {
        return {segments.data(), static_cast<long>(segments.size()), samples.data(),
                static_cast<long>(samples.size() / desired_width)};
    }
};

inline void make_reference(BoundReference* self, const Array& segments, const Array& samples) {
    new (self) BoundReference();
    if (segments.size() % 21 != 0 || samples.size() % desired_width != 0 || segments.size() + samples.size() == 0)
        throw nb::value_error("a reference has rows of 21 (segments) or 24 numbers (samples)");
    for (std::size_t k = 0; k < segments.size(); k += 21) {
        const double* row = segments.data() + k;
        self->segments.push_back({row[0], row[1], vector_from<3>(row + 2), vector_from<3>(row + 5),
                                  matrix_from(row + 8), vector_from<3>(row + 17), row[20]});
    }
    self->samples.assign(samples.data(), samples.data() + samples.size());
}

}  // namespace omnimorph::python
