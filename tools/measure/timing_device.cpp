#include "measure/timing_device.h"

namespace occlude::tools {

namespace {

// Adds its own lifetime to a sum of seconds.
class Span {
public:
    Span(const SecondsClock& clock, double& sum)
        : clock_(clock)
        , sum_(sum)
        , start_(clock())
    {
    }
    ~Span() { sum_ += clock_() - start_; }
    Span(const Span&) = delete;
    Span& operator=(const Span&) = delete;

private:
    const SecondsClock& clock_;
    double& sum_;
    double start_;
};

} // namespace

void TimingDevice::restart()
{
    verb_seconds_ = 0.0;
    wait_seconds_ = 0.0;
    read_seconds_ = 0.0;
    polls_ = 0;
}

void TimingDevice::begin_frame(const View& view)
{
    const Span span{clock_, verb_seconds_};
    inner().begin_frame(view);
}

void TimingDevice::draw(std::span<const ItemId> items, DrawPass pass)
{
    const Span span{clock_, verb_seconds_};
    inner().draw(items, pass);
}

void TimingDevice::query(const QueryBatch& batch, std::span<Ticket> tickets)
{
    const Span span{clock_, verb_seconds_};
    inner().query(batch, tickets);
}

Ticket TimingDevice::draw_and_query(std::span<const ItemId> items, DrawPass pass)
{
    const Span span{clock_, verb_seconds_};
    return inner().draw_and_query(items, pass);
}

void TimingDevice::flush()
{
    const Span span{clock_, verb_seconds_};
    inner().flush();
}

Answer TimingDevice::poll(Ticket ticket)
{
    const Span span{clock_, verb_seconds_};
    ++polls_;
    return inner().poll(ticket);
}

Answer TimingDevice::wait(Ticket ticket)
{
    const double start = clock_();
    const Answer answer = inner().wait(ticket);
    const double seconds = clock_() - start;
    verb_seconds_ += seconds;
    wait_seconds_ += seconds;
    return answer;
}

bool TimingDevice::read_depth(const PixelRect& rect, std::span<float> out)
{
    const double start = clock_();
    const bool read = inner().read_depth(rect, out);
    const double seconds = clock_() - start;
    verb_seconds_ += seconds;
    read_seconds_ += seconds;
    return read;
}

bool TimingDevice::read_depth_tiles(int tile_px, std::span<float> out)
{
    const double start = clock_();
    const bool read = inner().read_depth_tiles(tile_px, out);
    const double seconds = clock_() - start;
    verb_seconds_ += seconds;
    read_seconds_ += seconds;
    return read;
}

void TimingDevice::end_frame()
{
    const Span span{clock_, verb_seconds_};
    inner().end_frame();
}

} // namespace occlude::tools
