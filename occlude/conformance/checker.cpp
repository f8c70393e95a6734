#include <occlude/conformance/detail/checker.h>

#include <glm/ext/matrix_clip_space.hpp>
#include <glm/ext/matrix_transform.hpp>

#include <algorithm>

namespace occlude::conformance {

namespace {

constexpr size_t kMaxPerRule = 8;
constexpr uint32_t kMaxFramesToWait = 16;
constexpr uint32_t kPollsPerFrame = 64;
constexpr float kNear = 0.25f;
constexpr float kFar = 100.0f;

bool reads_as_visible(const Answer& answer)
{
    return answer.state == AnswerState::ready || answer.samples == Answer::kUnknownSamples;
}

} // namespace

View Checker::view(const glm::vec3& eye, const glm::vec3& ahead) const
{
    const glm::ivec2 size = host_.size_px();
    const ClipConvention convention = host_.convention();
    const bool reversed = convention.order == DepthOrder::near_is_large;
    const float near = reversed ? kFar : kNear;
    const float far = reversed ? kNear : kFar;
    const float aspect = static_cast<float>(size.x) / static_cast<float>(size.y);
    const float fov_y = glm::radians(90.0f);
    const glm::mat4 projection = convention.range == DepthRange::zero_to_one
                                     ? glm::perspectiveRH_ZO(fov_y, aspect, near, far)
                                     : glm::perspectiveRH_NO(fov_y, aspect, near, far);
    const glm::mat4 camera = glm::lookAtRH(eye, eye + ahead, glm::vec3{0.0f, 1.0f, 0.0f});
    return View::from_clip(projection * camera, size, convention);
}

void Checker::begin(const View& view)
{
    view_ = view;
    device().begin_frame(view);
}

void Checker::draw(std::initializer_list<size_t> items, DrawPass pass)
{
    std::vector<ItemId> ids;
    for (const size_t item : items) {
        ids.push_back(ItemId{item});
    }
    device().draw(ids, pass);
}

std::vector<Ticket> Checker::ask(std::span<const QueryBox> boxes, std::span<const uint32_t> ends)
{
    std::vector<Ticket> tickets(ends.size());
    device().query({boxes, ends, method_}, tickets);
    report_.tests += ends.size();
    return tickets;
}

Ticket Checker::ask(std::initializer_list<Aabb> boxes)
{
    std::vector<QueryBox> grown_boxes;
    for (const Aabb& box : boxes) {
        grown_boxes.push_back({grown(box), nullptr, NodeId{grown_boxes.size()}});
    }
    const uint32_t end = static_cast<uint32_t>(grown_boxes.size());
    return ask(grown_boxes, std::span{&end, 1}).front();
}

std::vector<Ticket> Checker::ask_each(std::span<const Aabb> boxes)
{
    std::vector<QueryBox> grown_boxes;
    std::vector<uint32_t> ends;
    for (const Aabb& box : boxes) {
        grown_boxes.push_back({grown(box), nullptr, NodeId{grown_boxes.size()}});
        ends.push_back(static_cast<uint32_t>(grown_boxes.size()));
    }
    return ask(grown_boxes, ends);
}

Answer Checker::resolve(Ticket ticket)
{
    if (device().caps().same_frame_results) {
        const Answer answer = device().wait(ticket);
        check("C9", answer.state != AnswerState::pending, "wait answers pending");
        check("C8", reads_as_visible(answer), "an answer that is not ready reads as hidden");
        return answer;
    }
    // Every frame gives the device time to finish; an answer that never comes is waited for.
    for (uint32_t frame = 0; frame < kMaxFramesToWait; ++frame) {
        for (uint32_t i = 0; i < kPollsPerFrame; ++i) {
            const Answer answer = device().poll(ticket);
            check("C8", reads_as_visible(answer), "an answer that is not ready reads as hidden");
            if (answer.state != AnswerState::pending) {
                return answer;
            }
        }
        device().begin_frame(view_);
        device().flush();
        device().end_frame();
    }
    const Answer answer = device().wait(ticket);
    check("C9", answer.state != AnswerState::pending, "wait answers pending");
    return answer;
}

Answer Checker::expect(std::string_view rule, Ticket ticket, Expect expected, std::string_view what)
{
    const Answer answer = resolve(ticket);
    const std::string subject{what};
    report_.visible += expected == Expect::visible ? 1u : 0u;
    if (answer.state == AnswerState::lost) {
        ++report_.lost;
        check("useful", options_.may_lose_answers, subject + ": the answer was lost");
        return answer;
    }
    report_.hidden += answer.samples == 0 ? 1u : 0u;
    if (expected == Expect::visible) {
        check(rule, answer.samples > 0, subject + ": answered 0, but it can be seen");
    } else if (expected == Expect::hidden) {
        check("useful", answer.samples == 0 || !options_.must_find_hidden,
              subject + ": answered " + std::to_string(answer.samples) +
                  " samples, but it is hidden far behind a wall");
    }
    return answer;
}

void Checker::check(std::string_view rule, bool kept, std::string_view sentence)
{
    if (kept) {
        return;
    }
    const auto same_rule = [&](const Violation& v) { return v.rule == rule; };
    auto& violations = report_.violations;
    if (std::count_if(violations.begin(), violations.end(), same_rule) <
        static_cast<std::ptrdiff_t>(kMaxPerRule)) {
        violations.push_back({std::string{rule}, std::string{"method "} + name(method_) + ": " +
                                                     std::string{sentence}});
    }
}

void Checker::expect_lost(std::string_view rule, const Answer& answer, std::string_view what)
{
    check(rule, answer.state == AnswerState::lost,
          std::string{what} + " does not answer lost but " +
              (answer.state == AnswerState::pending ? std::string{"pending"}
                                                    : std::to_string(answer.samples) + " samples"));
    check("C8", reads_as_visible(answer), std::string{what} + " reads as hidden");
}

} // namespace occlude::conformance
