#include "files/output_file.h"
#include "files/temporary_file.h"

#include "tools/temp_folder.h"

#include <gtest/gtest.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

namespace occlude::tools {

namespace {

namespace fs = std::filesystem;

std::string content_of(const fs::path& path)
{
    std::ifstream stream{path, std::ios::binary};
    return {std::istreambuf_iterator<char>{stream}, {}};
}

size_t files_in(const fs::path& directory)
{
    return static_cast<size_t>(std::distance(fs::directory_iterator{directory}, {}));
}

bool write(const fs::path& path, std::string_view content)
{
    auto file = OutputFile::open(path);
    return file && file->commit(content);
}

void expect_refused(const fs::path& path, std::string_view why)
{
    const auto refused = OutputFile::open(path);
    ASSERT_FALSE(refused) << path;
    EXPECT_NE(refused.error().message.find(path.string()), std::string::npos);
    EXPECT_NE(refused.error().message.find(why), std::string::npos) << refused.error().message;
}

} // namespace

TEST(OutputFile, IsThereCompletelyOrNotAtAll)
{
    const TempFolder folder;
    const fs::path path = folder.write("out.json", "before");
    {
        auto file = OutputFile::open(path);
        ASSERT_TRUE(file);
        EXPECT_EQ(content_of(path), "before");
        EXPECT_EQ(files_in(path.parent_path()), 1u); // nothing that an interrupt could leave
    }
    EXPECT_EQ(content_of(path), "before");
    ASSERT_TRUE(write(path, "after"));
    EXPECT_EQ(content_of(path), "after");
    EXPECT_EQ(files_in(path.parent_path()), 1u);
}

TEST(OutputFile, PlacesThatCannotBeWrittenAreNamedBeforehand)
{
    const TempFolder folder;
    expect_refused("", "empty");
    expect_refused(folder.path("no/out.json"), "create it first");
    expect_refused(folder.path(""), "directory");
    fs::create_symlink("b", folder.path("a"));
    fs::create_symlink("a", folder.path("b"));
    expect_refused(folder.path("a"), "circle");
}

TEST(OutputFile, ASymbolicLinkStaysAndItsTargetIsReplaced)
{
    const TempFolder folder;
    fs::create_directory(folder.path("deep"));
    folder.write("deep/real.json", "before");
    fs::create_symlink("deep/real.json", folder.path("second"));
    fs::create_symlink("second", folder.path("first"));
    ASSERT_TRUE(write(folder.path("first"), "after"));
    EXPECT_TRUE(fs::is_symlink(folder.path("first")));
    EXPECT_TRUE(fs::is_symlink(folder.path("second")));
    EXPECT_EQ(content_of(folder.path("deep/real.json")), "after");
    EXPECT_EQ(files_in(folder.path("deep")), 1u);
}

TEST(OutputFile, ALinkToNothingYetMakesTheFileThatItNames)
{
    const TempFolder folder;
    fs::create_symlink("later.json", folder.path("link"));
    ASSERT_TRUE(write(folder.path("link"), "text"));
    EXPECT_TRUE(fs::is_symlink(folder.path("link")));
    EXPECT_EQ(content_of(folder.path("later.json")), "text");
}

TEST(OutputFile, AFifoStaysAFifoAndItsReaderGetsEverything)
{
    const TempFolder folder;
    const std::string path = folder.path("pipe");
    ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
    const std::string sent(200000, 'x'); // more than a pipe holds
    std::string received;
    std::thread reader{[&] { received = content_of(path); }};
    EXPECT_TRUE(write(path, sent));
    reader.join();
    EXPECT_EQ(received, sent);
    EXPECT_TRUE(fs::is_fifo(path));
}

TEST(OutputFile, ADeviceNodeIsWrittenThrough)
{
    const TempFolder folder;
    fs::create_symlink("/dev/null", folder.path("null"));
    EXPECT_TRUE(write("/dev/null", "text"));
    EXPECT_TRUE(write(folder.path("null"), "text"));
    EXPECT_TRUE(fs::is_character_file("/dev/null"));
    EXPECT_TRUE(fs::is_symlink(folder.path("null")));
    EXPECT_EQ(files_in(folder.path("")), 1u);
}

TEST(OutputFile, AFullDeviceIsAnErrorWithASentence)
{
    auto file = OutputFile::open("/dev/full");
    ASSERT_TRUE(file);
    const auto written = file->commit("text");
    ASSERT_FALSE(written);
    EXPECT_EQ(written.error().message, "cannot write '/dev/full': No space left on device");
}

TEST(OutputFile, AFileOfTwoNamesKeepsBoth)
{
    const TempFolder folder;
    const std::string first = folder.write("first", "a longer text before");
    fs::create_hard_link(first, folder.path("second"));
    ASSERT_TRUE(write(first, "after"));
    EXPECT_EQ(content_of(folder.path("second")), "after");
}

TEST(OutputFile, PermissionsOfTheReplacedFileStay)
{
    const TempFolder folder;
    const std::string path = folder.write("out", "before");
    ASSERT_EQ(::chmod(path.c_str(), 0640), 0);
    ASSERT_TRUE(write(path, "after"));
    struct stat after {};
    ASSERT_EQ(::stat(path.c_str(), &after), 0);
    EXPECT_EQ(after.st_mode & 07777u, 0640u);
}

TEST(OutputFile, AFileThatStandardErrorGoesToIsContinuedNotReplaced)
{
    const TempFolder folder;
    const std::string path = folder.path("log");
    const int kept = ::dup(STDERR_FILENO);
    const int log = ::open(path.c_str(), O_WRONLY | O_CREAT, 0600);
    ASSERT_GE(::dup2(log, STDERR_FILENO), 0);
    const bool before = write_all(STDERR_FILENO, "table\n") == 0;
    const bool written = write("/dev/stderr", "json\n");
    const bool after = write_all(STDERR_FILENO, "end\n") == 0;
    ::dup2(kept, STDERR_FILENO);
    ::close(kept);
    ::close(log);
    EXPECT_TRUE(before && written && after);
    EXPECT_EQ(content_of(path), "table\njson\nend\n");
}

// Ctrl-C while a large file is being written: the process ends by the signal, and its temporary
// file is deleted.
TEST(TemporaryFile, ASignalThatEndsTheProgramRemovesIt)
{
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
        const TempFolder folder;
        std::array<int, 2> ready{};
        ASSERT_EQ(::pipe(ready.data()), 0);
        const pid_t child = ::fork();
        if (child == 0) {
            const TemporaryFile file{folder.path("out")};
            const bool told = write_all(ready[1], "x") == 0;
            while (told) {
                ::pause();
            }
            ::_exit(1);
        }
        char byte = 0;
        ASSERT_EQ(::read(ready[0], &byte, 1), 1);
        EXPECT_EQ(files_in(folder.path("")), 1u);
        ::kill(child, signal);
        int status = 0;
        ASSERT_EQ(::waitpid(child, &status, 0), child);
        EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == signal);
        EXPECT_EQ(files_in(folder.path("")), 0u);
        ::close(ready[0]);
        ::close(ready[1]);
    }
}

TEST(TemporaryFile, LeavesTheHandlersOfItsHostAlone)
{
    const TempFolder folder;
    const auto before = std::signal(SIGINT, SIG_IGN);
    {
        const TemporaryFile file{folder.path("out")};
        ASSERT_EQ(file.failed(), 0);
    }
    EXPECT_EQ(std::signal(SIGINT, before), SIG_IGN);
}

TEST(TemporaryFile, WhatADeadProcessOfTheSameNumberLeftIsNotInTheWay)
{
    const TempFolder folder;
    folder.write("out." + std::to_string(::getpid()) + ".part", "stale");
    EXPECT_TRUE(write(folder.path("out"), "text"));
    EXPECT_EQ(content_of(folder.path("out")), "text");
    EXPECT_EQ(files_in(folder.path("")), 1u);
}

} // namespace occlude::tools
