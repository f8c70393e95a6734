#include <occlude/backends/gl/detail/gl_flag_batch.h>

#include <algorithm>
#include <utility>

namespace occlude {

bool GlFlagBatch::begin(size_t tests, GLuint binding)
{
    forget_fence();
    flags_.assign(tests, 0);
    glBindBuffer(GL_SHADER_STORAGE_BUFFER, buffer_.name());
    glBufferData(GL_SHADER_STORAGE_BUFFER, static_cast<GLsizeiptr>(tests * sizeof(uint32_t)),
                 flags_.data(), GL_STREAM_READ);
    GLint64 size = 0;
    glGetBufferParameteri64v(GL_SHADER_STORAGE_BUFFER, GL_BUFFER_SIZE, &size);
    if (size != static_cast<GLint64>(tests * sizeof(uint32_t))) {
        std::ranges::fill(flags_, 1u);
        return false;
    }
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, buffer_.name());
    return true;
}

void GlFlagBatch::end()
{
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    fence_ = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
}

bool GlFlagBatch::available()
{
    // Anything but a timeout is final, also a failure, which seen() handles.
    return fence_ == nullptr ||
           glClientWaitSync(fence_, GL_SYNC_FLUSH_COMMANDS_BIT, 0) != GL_TIMEOUT_EXPIRED;
}

bool GlFlagBatch::seen(size_t test)
{
    if (fence_ != nullptr) {
        std::ranges::fill(flags_, 1u); // stays so if the driver fails
        glBindBuffer(GL_COPY_READ_BUFFER, buffer_.name());
        glGetBufferSubData(GL_COPY_READ_BUFFER, 0,
                           static_cast<GLsizeiptr>(flags_.size() * sizeof(uint32_t)),
                           flags_.data());
        glBindBuffer(GL_COPY_READ_BUFFER, 0);
        forget_fence();
    }
    return test >= flags_.size() || flags_[test] != 0;
}

void GlFlagBatch::forget_fence()
{
    if (fence_ != nullptr && GlNamesAreForeign::now()) {
        fence_ = nullptr;
    } else if (fence_ != nullptr) {
        glDeleteSync(std::exchange(fence_, nullptr));
    }
}

std::shared_ptr<GlFlagBatch> GlFlagBatches::take()
{
    for (size_t tried = 0; tried < batches_.size(); ++tried) {
        next_ = (next_ + 1) % batches_.size();
        if (batches_[next_].use_count() == 1) {
            return batches_[next_];
        }
    }
    batches_.push_back(std::make_shared<GlFlagBatch>());
    return batches_.back();
}

} // namespace occlude
