// The bug "depth-writes-in-tests": a device whose tests write to the depth buffer.
#pragma once

#include <occlude/core/query_device.h>

#include <epoxy/gl.h>

namespace gl_engine {

class WritingDevice final : public occlude::QueryDevice {
public:
    WritingDevice(occlude::QueryDevice& inner, bool writes)
        : inner_(inner)
        , writes_(writes)
    {
    }

    const occlude::DeviceCaps& caps() const override { return inner_.caps(); }
    void begin_frame(const occlude::View& view) override { inner_.begin_frame(view); }
    void draw(std::span<const occlude::ItemId> items, occlude::DrawPass pass) override
    {
        inner_.draw(items, pass);
    }
    void query(const occlude::QueryBatch& batch, std::span<occlude::Ticket> tickets) override
    {
        inner_.query(batch, tickets);
        if (writes_) { // as if the depth mask were forgotten
            glDepthMask(GL_TRUE);
            const GLfloat near_value = 1.0f;
            glEnable(GL_SCISSOR_TEST);
            glScissor(0, 0, 32, 32);
            glClearBufferfv(GL_DEPTH, 0, &near_value);
            glDisable(GL_SCISSOR_TEST);
            glDepthMask(GL_FALSE);
        }
    }
    occlude::Ticket draw_and_query(std::span<const occlude::ItemId> items,
                                   occlude::DrawPass pass) override
    {
        return inner_.draw_and_query(items, pass);
    }
    void flush() override { inner_.flush(); }
    occlude::Answer poll(occlude::Ticket ticket) override { return inner_.poll(ticket); }
    occlude::Answer wait(occlude::Ticket ticket) override { return inner_.wait(ticket); }
    bool read_depth(const occlude::PixelRect& rect, std::span<float> out) override
    {
        return inner_.read_depth(rect, out);
    }
    void end_frame() override { inner_.end_frame(); }

private:
    occlude::QueryDevice& inner_;
    bool writes_;
};

} // namespace gl_engine
