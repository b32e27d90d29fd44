#include <treelet/file/file_bytes.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <random>
#include <string>
#include <system_error>

#include <treelet/core/array.h>

#if !defined(_WIN32)
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
#endif

namespace treelet {
namespace {

namespace fs = std::filesystem;

FileBytes own(Array<std::byte> memory) {
  const auto owner = std::make_shared<const Array<std::byte>>(std::move(memory));
  return {{owner->data(), owner->size()}, owner};
}

[[noreturn]] void throw_system_error(int error, const fs::path& path) {
  throw std::system_error(error, std::generic_category(), path.string());
}

/// For opening: a folder opens well and reads badly.
void require_regular(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (status.type() == fs::file_type::not_found) throw_system_error(ENOENT, path);
  if (error) throw_system_error(error.value(), path);
  if (status.type() == fs::file_type::directory) throw_system_error(EISDIR, path);
  if (status.type() != fs::file_type::regular) throw_system_error(EINVAL, path);
}

/// A name beside `path` that nobody uses.
fs::path temporary_name(const fs::path& path) {
  std::random_device random;
  constexpr char kDigits[] = "0123456789abcdef";
  std::string suffix = ".";
  for (int i = 0; i < 16; ++i) suffix += kDigits[random() & 15];
  fs::path name = path;
  name += suffix + ".tmp";
  return name;
}

/// Where to write: through links, and never over what is no file.
fs::path writable_target(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (status.type() == fs::file_type::directory) throw_system_error(EISDIR, path);
  const bool is_new = status.type() == fs::file_type::not_found;
  if (!is_new && status.type() != fs::file_type::regular) throw_system_error(EINVAL, path);
  if (!fs::is_symlink(path, error)) return path;
  return is_new ? path.parent_path() / fs::read_symlink(path) : fs::canonical(path);
}

/// What is replaced keeps its permissions.
void keep_permissions(const fs::path& from, const fs::path& to) {
  std::error_code error;
  const fs::file_status status = fs::status(from, error);
  if (status.type() == fs::file_type::regular) fs::permissions(to, status.permissions(), error);
}

#if !defined(_WIN32)

/// An open file.
class Descriptor {
 public:
  Descriptor(const fs::path& path, int flags)
      : path_(path), number_(::open(path.c_str(), flags | O_CLOEXEC, 0666)) {
    if (number_ < 0) throw_system_error(errno, path_);
  }
  ~Descriptor() { ::close(number_); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  std::size_t size() const {
    struct stat status = {};
    if (::fstat(number_, &status) != 0) throw_system_error(errno, path_);
    return std::size_t(status.st_size);
  }

  FileBytes map() const {
    const std::size_t bytes = size();
    if (bytes == 0) return {};
    void* const memory = ::mmap(nullptr, bytes, PROT_READ, MAP_SHARED, number_, 0);
    if (memory == MAP_FAILED) throw_system_error(errno, path_);
    ::madvise(memory, bytes, MADV_WILLNEED);
    const std::shared_ptr<const void> owner(
        memory, [bytes](const void* mapped) { ::munmap(const_cast<void*>(mapped), bytes); });
    return {{static_cast<const std::byte*>(memory), bytes}, owner};
  }

  void write(std::span<const std::byte> bytes) const {
    while (!bytes.empty()) {
      const ssize_t written = ::write(number_, bytes.data(), bytes.size());
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) throw_system_error(errno, path_);
      bytes = bytes.subspan(std::size_t(written));
    }
  }

  /// Waits for the disk: else a power failure might leave the new name with no content.
  void sync() const {
    if (::fsync(number_) != 0) throw_system_error(errno, path_);
  }

 private:
  const fs::path& path_;
  const int number_;
};

void write_new_file(const fs::path& path, std::span<const std::span<const std::byte>> parts) {
  const Descriptor file(path, O_WRONLY | O_CREAT | O_EXCL);
  for (const std::span<const std::byte> part : parts) file.write(part);
  file.sync();
}

#else

void write_new_file(const fs::path& path, std::span<const std::span<const std::byte>> parts) {
  std::ofstream file(path, std::ios::binary);
  for (const std::span<const std::byte> part : parts) {
    file.write(reinterpret_cast<const char*>(part.data()), std::streamsize(part.size()));
  }
  file.close();
  if (!file) throw_system_error(EIO, path);
}

#endif

/// Removes what an error leaves behind.
class TemporaryFile {
 public:
  explicit TemporaryFile(const fs::path& target) : path_(temporary_name(target)) {}
  ~TemporaryFile() {
    std::error_code ignored;
    if (!path_.empty()) fs::remove(path_, ignored);
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  const fs::path& path() const { return path_; }
  void move_to(const fs::path& target) {
    keep_permissions(target, path_);
    std::error_code error;
    fs::rename(path_, target, error);
    if (error) throw_system_error(error.value(), target);
    path_.clear();
  }

 private:
  fs::path path_;
};

}  // namespace

FileBytes map_file(const fs::path& path) {
  require_regular(path);
#if defined(_WIN32)
  return read_file(path);
#else
  return Descriptor(path, O_RDONLY).map();
#endif
}

FileBytes read_file(const fs::path& path) {
  require_regular(path);
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file) throw_system_error(errno != 0 ? errno : EIO, path);
  Array<std::byte> memory(fs::file_size(path));
  file.read(reinterpret_cast<char*>(memory.data()), std::streamsize(memory.size()));
  if (!file) throw_system_error(EIO, path);
  return own(std::move(memory));
}

FileBytes copy_bytes(std::span<const std::byte> bytes) {
  Array<std::byte> memory(bytes.size());
  std::copy(bytes.begin(), bytes.end(), memory.begin());
  return own(std::move(memory));
}

void replace_file(const fs::path& path, std::span<const std::span<const std::byte>> parts) {
  const fs::path target = writable_target(path);
  TemporaryFile file(target);
  write_new_file(file.path(), parts);
  file.move_to(target);
}

}  // namespace treelet
