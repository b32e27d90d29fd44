#include "symbol_name.h"

#include <cxxabi.h>
#include <dlfcn.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#if defined(__linux__)
#include <elf.h>
#include <fcntl.h>
#include <link.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
#endif

// Kernels in anonymous namespaces are in no dynamic symbol table: dladdr() does not know them. The
// table in the program's file does.

namespace treelet::emulator {
namespace {

#if defined(__linux__)
/// The mangled name of the function at an address of the file's image.
const char* find_in_image(const char* image, std::uintptr_t address) {
  const auto* header = reinterpret_cast<const ElfW(Ehdr)*>(image);
  const auto* sections = reinterpret_cast<const ElfW(Shdr)*>(image + header->e_shoff);
  for (unsigned s = 0; s < header->e_shnum; ++s) {
    if (sections[s].sh_type != SHT_SYMTAB) continue;
    const auto* symbols = reinterpret_cast<const ElfW(Sym)*>(image + sections[s].sh_offset);
    const char* names = image + sections[sections[s].sh_link].sh_offset;
    for (std::size_t i = 0; i < sections[s].sh_size / sizeof *symbols; ++i) {
      if (symbols[i].st_value == address && symbols[i].st_name != 0)
        return names + symbols[i].st_name;
    }
  }
  return nullptr;
}

/// Copies the mangled name; the file stays mapped for no longer than needed.
bool find_in_file(const char* path, std::uintptr_t address, char* name, std::size_t capacity) {
  const int file = open(path, O_RDONLY);
  struct stat status{};
  if (file < 0 || fstat(file, &status) != 0) return false;
  void* image = mmap(nullptr, std::size_t(status.st_size), PROT_READ, MAP_PRIVATE, file, 0);
  close(file);
  if (image == MAP_FAILED) return false;
  const char* found = nullptr;
  if (std::memcmp(image, ELFMAG, SELFMAG) == 0) {
    found = find_in_image(static_cast<const char*>(image), address);
  }
  if (found != nullptr) std::snprintf(name, capacity, "%s", found);
  munmap(image, std::size_t(status.st_size));
  return found != nullptr;
}
#endif

bool find_mangled(const void* address, char* name, std::size_t capacity) {
  Dl_info info{};
  if (dladdr(address, &info) == 0) return false;
  if (info.dli_sname != nullptr && info.dli_saddr == address) {
    std::snprintf(name, capacity, "%s", info.dli_sname);
    return true;
  }
#if defined(__linux__)
  const auto value = reinterpret_cast<std::uintptr_t>(address);
  const auto base = reinterpret_cast<std::uintptr_t>(info.dli_fbase);
  // dli_fname is argv[0] for the program itself.
  return find_in_file("/proc/self/exe", value - base, name, capacity) ||
         find_in_file(info.dli_fname, value - base, name, capacity) ||
         find_in_file("/proc/self/exe", value, name, capacity);
#else
  return false;
#endif
}

}  // namespace

void find_symbol_name(const void* address, char* name, std::size_t capacity) {
  if (!find_mangled(address, name, capacity)) {
    std::snprintf(name, capacity, "at %p", address);
    return;
  }
  int status = 0;
  char* demangled = abi::__cxa_demangle(name, nullptr, nullptr, &status);
  if (demangled == nullptr) return;
  std::snprintf(name, capacity, "%s", demangled);
  std::free(demangled);
}

}  // namespace treelet::emulator
