"""A frame of the demo as an array, and as a file that any viewer shows."""
import taut

scene = taut.load("scenes/nunchaku.toml")
picture = scene.render(time=6.9, size=(480, 270))  # (270, 480, 4), uint8: red, green, blue, opacity
with open("frame.ppm", "wb") as file:
    file.write(b"P6 %d %d 255\n" % (picture.shape[1], picture.shape[0]))
    file.write(picture[:, :, :3].tobytes())
print(picture.shape, "mean colour", picture[:, :, :3].mean(axis=(0, 1)).round(1))
