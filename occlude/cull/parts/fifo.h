// A first-in first-out queue over one vector. Unlike std::queue, it allocates nothing once it has
// grown.
#pragma once

#include <occlude/core/assert.h>

#include <cstddef>
#include <utility>
#include <vector>

namespace occlude {

template <class T>
class Fifo {
public:
    bool empty() const { return head_ == items_.size(); }
    size_t size() const { return items_.size() - head_; }
    const T& front() const
    {
        OCCLUDE_ASSERT(!empty(), "an empty queue has no front");
        return items_[head_];
    }
    void push(T item) { items_.push_back(std::move(item)); }

    T pop()
    {
        OCCLUDE_ASSERT(!empty(), "an empty queue has nothing to pop");
        T item = std::move(items_[head_++]);
        if (empty()) {
            clear();
        }
        return item;
    }
    void clear()
    {
        items_.clear();
        head_ = 0;
    }

private:
    std::vector<T> items_;
    size_t head_ = 0;
};

} // namespace occlude
