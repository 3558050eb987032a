// libosmesa_glx.so as a program meets it that calls GLX itself. Run by `headless`, without an X
// server.
// Before X11, whose macros (None, Bool) it does not survive.
#include <gtest/gtest.h>

#define GL_GLEXT_PROTOTYPES
#include <GL/gl.h>
#include <GL/glx.h>
#include <X11/Xlib.h>

#include <array>

namespace {

using Pixel = std::array<int, 3>;

Pixel pixel(int x, int y)
{
  unsigned char bytes[4] = {};
  glReadPixels(x, y, 1, 1, GL_RGBA, GL_UNSIGNED_BYTE, bytes);
  return {bytes[0], bytes[1], bytes[2]};
}

void fill(float red, float green, float blue)
{
  glClearColor(red, green, blue, 1.0F);
  glClear(GL_COLOR_BUFFER_BIT);
}

const Pixel RED{255, 0, 0};
const Pixel BLUE{0, 0, 255};

class Glx : public testing::Test
{
 protected:
  void SetUp() override
  {
    display_ = XOpenDisplay(nullptr);
    ASSERT_NE(display_, nullptr);
    ASSERT_STREQ(glXGetClientString(display_, GLX_VENDOR), "osmesa_glx");
    const int wanted[] = {GLX_DOUBLEBUFFER, True, GLX_DEPTH_SIZE, 24, None};
    int count = 0;
    GLXFBConfig* list = glXChooseFBConfig(display_, DefaultScreen(display_), wanted, &count);
    ASSERT_EQ(count, 1);
    config_ = list[0];
    XFree(list);
  }

  void TearDown() override { glXMakeCurrent(display_, None, nullptr); }

  Window createWindow(unsigned int width, unsigned int height)
  {
    return XCreateSimpleWindow(display_, DefaultRootWindow(display_), 0, 0, width, height, 0, 0, 0);
  }

  GLXContext createContext(GLXContext share = nullptr)
  {
    return glXCreateNewContext(display_, config_, GLX_RGBA_TYPE, share, True);
  }

  Display* display_ = nullptr;
  GLXFBConfig config_ = nullptr;
};

TEST_F(Glx, what_cannot_be_had_is_not_offered)
{
  for (const int name : {GLX_STEREO, GLX_SAMPLES, GLX_SAMPLE_BUFFERS}) {
    const int wanted[] = {name, 1, None};
    int count = 7;
    EXPECT_EQ(glXChooseFBConfig(display_, 0, wanted, &count), nullptr);
    EXPECT_EQ(count, 0);
  }
  int value = -1;
  EXPECT_EQ(glXGetFBConfigAttrib(display_, config_, GLX_STENCIL_SIZE, &value), 0);
  EXPECT_EQ(value, 8);
  EXPECT_EQ(glXGetFBConfigAttrib(display_, config_, GLX_SAMPLES, &value), 0);
  EXPECT_EQ(value, 0);
}

TEST_F(Glx, a_window_is_drawn_and_followed_when_it_grows)
{
  const Window window = createWindow(20, 10);
  GLXContext context = createContext();
  ASSERT_TRUE(glXMakeCurrent(display_, window, context));
  EXPECT_EQ(glXGetCurrentContext(), context);
  EXPECT_EQ(glXGetCurrentDrawable(), window);
  fill(1, 0, 0);
  EXPECT_EQ(pixel(19, 9), RED);

  // No frame is finished in between: setting the viewport is what tells.
  XResizeWindow(display_, window, 200, 100);
  glViewport(0, 0, 200, 100);
  fill(0, 0, 1);
  EXPECT_EQ(pixel(199, 99), BLUE);

  // Here finishing the frame is.
  XResizeWindow(display_, window, 300, 150);
  glXSwapBuffers(display_, window);
  fill(1, 0, 0);
  EXPECT_EQ(pixel(299, 149), RED);
  EXPECT_EQ(glGetError(), GLenum(GL_NO_ERROR));
  glXDestroyContext(display_, context);
  XDestroyWindow(display_, window);
}

TEST_F(Glx, the_back_buffer_is_the_buffer)
{
  const Window window = createWindow(4, 4);
  GLXContext context = createContext();
  ASSERT_TRUE(glXMakeCurrent(display_, window, context));
  glDrawBuffer(GL_BACK);
  fill(0, 0, 1);
  glReadBuffer(GL_BACK);
  EXPECT_EQ(pixel(2, 2), BLUE);
  glReadBuffer(GL_FRONT);
  EXPECT_EQ(pixel(2, 2), BLUE);
  EXPECT_EQ(glGetError(), GLenum(GL_NO_ERROR));
  glXDestroyContext(display_, context);
  XDestroyWindow(display_, window);
}

TEST_F(Glx, contexts_share_textures_if_asked_to)
{
  const Window window = createWindow(8, 8);
  GLXContext first = createContext();
  ASSERT_TRUE(glXMakeCurrent(display_, window, first));
  GLuint texture = 0;
  glGenTextures(1, &texture);
  glBindTexture(GL_TEXTURE_2D, texture);
  GLXContext sharing = createContext(first);
  GLXContext alone = createContext();
  ASSERT_TRUE(glXMakeCurrent(display_, window, sharing));
  EXPECT_TRUE(glIsTexture(texture));
  ASSERT_TRUE(glXMakeCurrent(display_, window, alone));
  EXPECT_FALSE(glIsTexture(texture));
  for (GLXContext context : {first, sharing, alone}) {
    glXDestroyContext(display_, context);
  }
  XDestroyWindow(display_, window);
}

TEST_F(Glx, pbuffers_have_the_size_that_was_asked_for)
{
  const int size[] = {GLX_PBUFFER_WIDTH, 64, GLX_PBUFFER_HEIGHT, 32, None};
  const GLXPbuffer pbuffer = glXCreatePbuffer(display_, config_, size);
  unsigned int width = 0;
  unsigned int height = 0;
  glXQueryDrawable(display_, pbuffer, GLX_WIDTH, &width);
  glXQueryDrawable(display_, pbuffer, GLX_HEIGHT, &height);
  EXPECT_EQ(width, 64u);
  EXPECT_EQ(height, 32u);
  GLXContext context = createContext();
  ASSERT_TRUE(glXMakeCurrent(display_, pbuffer, context));
  fill(1, 0, 0);
  EXPECT_EQ(pixel(63, 31), RED);
  glXDestroyContext(display_, context);
  glXDestroyPbuffer(display_, pbuffer);
}

TEST_F(Glx, what_is_gone_is_not_touched)
{
  const Window window = createWindow(8, 8);
  GLXContext context = createContext();
  ASSERT_TRUE(glXMakeCurrent(display_, window, context));
  // The window goes while OSMesa is bound to its pixels.
  XDestroyWindow(display_, window);
  fill(1, 0, 0);
  glXSwapBuffers(display_, window);
  glXDestroyContext(display_, context);
  EXPECT_EQ(glXGetCurrentContext(), nullptr);
  EXPECT_EQ(glXGetCurrentDisplay(), nullptr);
  glXDestroyContext(display_, context);
  EXPECT_FALSE(glXMakeCurrent(display_, window, context));
  glXSwapBuffers(display_, window);
}

TEST_F(Glx, functions_are_found_by_name)
{
  const auto find = [](const char* name) {
    return glXGetProcAddressARB(reinterpret_cast<const GLubyte*>(name));
  };
  EXPECT_EQ(reinterpret_cast<void*>(find("glXSwapBuffers")),
            reinterpret_cast<void*>(&glXSwapBuffers));
  EXPECT_EQ(reinterpret_cast<void*>(find("glViewport")), reinterpret_cast<void*>(&glViewport));
  EXPECT_NE(find("glCreateShader"), nullptr);
  EXPECT_EQ(find("glXNoSuchFunction"), nullptr);
}

}  // namespace

int main(int argc, char** argv)
{
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
