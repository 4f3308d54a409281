// XML documents whose elements hold arrays of numbers: the content of an array is found by its place in the file.
#pragma once

#include "io/read/arrays/array_file.hpp"
#include "io/xml/xml.hpp"

namespace lamella {

class ArrayXml : public XmlReader {
protected:
    /// `root` is the name of the outermost element, `array_tag` how the tag of an array begins, "<DataArray".
    ArrayXml(ArrayFile& file, std::string_view root, std::string_view array_tag, bool may_name_type = false)
        : XmlReader(may_name_type), file_(file), root_path_("/" + std::string(root)), array_tag_(array_tag) {}

    /// Parses all. Throws errors.
    void parse_document();

    /// An element begins or ends, whose path is path().
    virtual void begin_path(const XmlAttributes& attributes) = 0;
    virtual void end_path() {}
    void text(std::string_view /*piece*/) override {}

    /// Names of open elements, "/VTKFile/PolyData"; those with a namespace are "other".
    std::string_view path() const noexcept { return path_; }

    /// Sets `content` to what is between the tag at hand and the next.
    void begin_content(std::string_view& content) {
        content_ = &content;
        content = file_.text.substr(event_end(), 0);
    }

    /// The number that an attribute is; 0 if it is absent.
    std::uint64_t count(const XmlAttributes& attributes, std::string_view name) const;
    /// True if an attribute is the second of two values, one of which it must be; it is the first if it is absent.
    bool is_second(const XmlAttributes& attributes, std::string_view name, std::string_view first,
                   std::string_view second) const;

    /// Throws an error at the tag at hand.
    [[noreturn]] void refuse(const std::string& what) const { throw TextError{event(), what}; }
    const char* event() const { return file_.text.data() + event_offset(); }

    ArrayFile& file_;

private:
    void begin_element(const XmlName& name, const XmlAttributes& attributes) final;
    void end_element(const XmlName& name) final;
    void end_content();

    std::string root_path_;
    std::string array_tag_;
    std::string path_;
    std::uint64_t tag_end_ = 0;            ///< of the last element that began
    std::string_view* content_ = nullptr;  ///< which has not ended
};

/// Warns of a name whose prefix is not declared.
void warn_unbound(const ArrayFile& file, const XmlReader& document, MeshFile& mesh);

/// True if a file begins as XML and soon has this tag, "<VTKFile".
bool begins_as_xml(const FileSource& source, std::string_view tag);

}  // namespace lamella
