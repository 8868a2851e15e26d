"""Pictures and what is asked of them: encoding, queries, framing, finding topics."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
import simplejpeg
from sample_pictures import BLUE, RED, is_like, jpeg, raw, two_halves

from telex_teleop.web.video import mjpeg, pages, query
from telex_teleop.web.video.pictures import (
    PNG,
    CompressedPicture,
    RawPicture,
    UnusablePictureError,
    Variant,
    encode,
)
from telex_teleop.web.video.topics import PictureTopic, base_topics, find_cameras, find_topic


def shown(encoded):
    """Return size and the colours left and right of the middle."""
    pixels = simplejpeg.decode_jpeg(encoded.data, colorspace="RGB")
    height, width = pixels.shape[:2]
    middle = pixels[height // 2]
    return (width, height), middle[width // 4], middle[3 * width // 4]


# Encoding


@pytest.mark.parametrize(
    "variant",
    [Variant(), Variant(unchanged=True), Variant(width=64), Variant(width=64, height=48)],
)
def test_a_jpeg_of_which_no_change_is_asked_keeps_its_bytes(variant):
    data = jpeg()
    encoded = encode(CompressedPicture(1.5, data), variant, 80)
    assert (encoded.data, encoded.stamp, encoded.mime) == (data, 1.5, "image/jpeg")


@pytest.mark.parametrize(
    ("variant", "size"),
    [
        (Variant(width=32), (32, 48)),
        (Variant(height=96), (64, 96)),
        (Variant(width=16, height=12), (16, 12)),
        (Variant(quality=30), (64, 48)),
    ],
)
def test_sizes_and_quality_of_compressed_pictures(variant, size):
    encoded = encode(CompressedPicture(0.0, jpeg()), variant, 95)
    found, left, right = shown(encoded)
    assert found == size
    assert is_like(left, RED)
    assert is_like(right, BLUE)


def test_quality_changes_the_size_of_the_data():
    noise = np.random.default_rng(1).integers(0, 255, (48, 64, 3), np.uint8)
    picture = CompressedPicture(0.0, jpeg(100, noise))
    small = encode(picture, Variant(quality=10), 95)
    large = encode(picture, Variant(quality=90), 95)
    assert len(small.data) < len(large.data) / 2
    by_default = encode(raw("rgb8", noise), Variant(), 10)
    assert len(by_default.data) == pytest.approx(len(small.data), rel=0.05)


def test_invert_turns_the_picture():
    _, left, right = shown(encode(CompressedPicture(0.0, jpeg()), Variant(invert=True), 95))
    assert is_like(left, BLUE)
    assert is_like(right, RED)


def test_png_is_handed_on_or_made_a_jpeg():
    png = cv2.imencode(".png", two_halves()[:, :, ::-1])[1].tobytes()
    picture = CompressedPicture(0.0, png)
    kept = encode(picture, Variant(unchanged=True), 95)
    assert (kept.data, kept.mime) == (png, "image/png")
    _, left, right = shown(encode(picture, Variant(), 95))
    assert is_like(left, RED)
    assert is_like(right, BLUE)


@pytest.mark.parametrize(
    ("size", "asked", "made"),
    [
        ((64, 48), (32, 24), (32, 24)),
        ((64, 48), (32, None), (32, 24)),
        ((64, 48), (None, 12), (16, 12)),
        ((64, 48), (60, 12), (16, 12)),
        ((64, 48), (640, 480), None),
        ((64, 48), (64, 48), None),
        ((200, 2), (10, 10), (10, 1)),
    ],
)
def test_a_picture_is_scaled_down_into_a_box_but_never_up(size, asked, made):
    data = jpeg(90, two_halves(*size))
    encoded = encode(CompressedPicture(0.0, data), Variant(*asked, fit=True), 95)
    if made is None:
        assert encoded.data is data
    else:
        assert shown(encoded)[0] == made


@pytest.mark.parametrize("source", ["jpeg", "png", "rgb8", "bgra8", "mono8"])
def test_png_streams(source):
    pixels = two_halves()
    if source == "jpeg":
        picture = CompressedPicture(0.0, jpeg())
    elif source == "png":
        picture = CompressedPicture(0.0, cv2.imencode(".png", pixels[:, :, ::-1])[1].tobytes())
    else:
        order = {"rgb8": [0, 1, 2], "bgra8": [2, 1, 0, 0], "mono8": [0]}[source]
        picture = raw(source, np.ascontiguousarray(pixels[:, :, order]))
    encoded = encode(picture, Variant(mime=PNG), 95)
    assert encoded.mime == PNG
    assert (encoded.data == getattr(picture, "data", None)) == (source == "png")
    read = cv2.imdecode(np.frombuffer(encoded.data, np.uint8), cv2.IMREAD_COLOR)[:, :, ::-1]
    assert read.shape == (48, 64, 3)
    left = (RED[0],) * 3 if source == "mono8" else RED
    assert is_like(read[24, 16], left)
    small = encode(picture, Variant(width=10, mime=PNG), 95)
    assert cv2.imdecode(np.frombuffer(small.data, np.uint8), 1).shape == (48, 10, 3)


@pytest.mark.parametrize("big_endian", [False, True])
@pytest.mark.parametrize(("encoding", "kind"), [("32FC1", "f4"), ("16UC1", "u2")])
def test_depth_is_shown_as_grey(encoding, kind, big_endian):
    depth = np.zeros((4, 6), np.dtype((">" if big_endian else "<") + kind))
    depth[:, :3], depth[:, 3:] = 1000, 2000
    if kind == "f4":
        depth[0, 0], depth[0, 5] = np.nan, np.inf
    picture = RawPicture(0.0, 6, 4, depth.strides[0], encoding, depth.tobytes(), 0.0, big_endian)
    read = cv2.imdecode(np.frombuffer(encode(picture, Variant(mime=PNG), 95).data, np.uint8), 0)
    assert read[2].tolist() == [127] * 3 + [255] * 3
    if kind == "f4":
        assert read[0, 0] == read[0, 5] == 0


@pytest.mark.parametrize("padding", [0, 5])
@pytest.mark.parametrize(
    ("encoding", "order"),
    [("rgb8", [0, 1, 2]), ("bgr8", [2, 1, 0]), ("rgba8", [0, 1, 2, 0]), ("bgra8", [2, 1, 0, 0])],
)
def test_raw_pictures_keep_their_colours(encoding, order, padding):
    pixels = np.ascontiguousarray(two_halves()[:, :, order])
    encoded = encode(raw(encoding, pixels, padding), Variant(), 95)
    size, left, right = shown(encoded)
    assert size == (64, 48)
    assert encoded.stamp == 1.5
    assert is_like(left, RED)
    assert is_like(right, BLUE)


@pytest.mark.parametrize("variant", [Variant(), Variant(width=20), Variant(invert=True)])
def test_grey_pictures_stay_grey(variant):
    pixels = np.full((48, 64, 1), 90, np.uint8)
    encoded = encode(raw("mono8", pixels), variant, 95)
    assert simplejpeg.decode_jpeg_header(encoded.data)[2] == "Gray"
    again = encode(CompressedPicture(0.0, encoded.data), Variant(width=10), 95)
    assert simplejpeg.decode_jpeg_header(again.data)[1:3] == (10, "Gray")


@pytest.mark.parametrize(
    ("picture", "said"),
    [
        (CompressedPicture(0.0, b""), "is neither JPEG nor PNG"),
        (CompressedPicture(0.0, b"GIF89a"), "is neither JPEG nor PNG"),
        (CompressedPicture(0.0, b"\xff\xd8nonsense"), "is a damaged JPEG"),
        (CompressedPicture(0.0, jpeg()[:60]), "is a damaged JPEG"),
        (CompressedPicture(0.0, b"\x89PNG\r\n\x1a\nnonsense"), "is a damaged PNG"),
        (CompressedPicture(0.0, b"\x89PNG\r\n\x1a\n"), "is a damaged PNG"),
        (RawPicture(0.0, 2, 2, 4, "yuv422", bytes(8)), "has the encoding 'yuv422'; known are rgb8"),
        (RawPicture(0.0, 2, 2, 2, "16UC1", bytes(4)), "has 4 bytes, which do not fit 2 x 2 16UC1"),
        (RawPicture(0.0, 2, 2, 6, "rgb8", bytes(11)), "has 11 bytes, which do not fit 2 x 2 rgb8"),
        (RawPicture(0.0, 2, 2, 5, "rgb8", bytes(10)), "has 10 bytes, which do not fit"),
        (RawPicture(0.0, 0, 0, 0, "rgb8", b""), "has 0 bytes, which do not fit 0 x 0"),
    ],
)
def test_damaged_pictures_are_refused_with_a_reason(picture, said):
    with pytest.raises(UnusablePictureError) as error:
        encode(picture, Variant(width=10), 95)
    assert str(error.value).startswith(said)


# Queries


def test_a_query_without_wishes_changes_nothing():
    assert query.parse_stream({"topic": "x"}, 4096) == query.PictureQuery("x", Variant())
    as_upstream = {"topic": "x", "width": "-1", "height": "0", "bitrate": "x", "type": "mjpeg"}
    assert query.parse_stream(as_upstream, 4096).variant == Variant()


def test_wishes_are_read():
    asked = {"topic": "x", "width": "320", "height": "240", "quality": "50", "invert": ""}
    assert query.parse_stream(asked, 4096).variant == Variant(320, 240, 50, invert=True)
    # Where there is no compressed topic, it is an MJPEG stream with all its wishes.
    asked["type"] = "ros_compressed"
    variant = Variant(320, 240, 50, invert=True, unchanged=True)
    assert query.parse_stream(asked, 4096).variant == variant


def test_png_has_a_compression_level():
    asked = {"topic": "x", "type": "png", "quality": "0"}
    assert query.parse_stream(asked, 4096).variant == Variant(quality=0, mime=PNG)
    assert query.parse_snapshot(asked, 4096).variant == Variant(quality=0, mime=PNG)
    del asked["quality"]
    assert query.parse_stream(asked, 4096).variant == Variant(mime=PNG)
    assert query.parse_stream({"topic": "x"}, 4096, "png").variant == Variant(mime=PNG)


def test_a_snapshot_is_a_jpeg_whatever_film_is_asked_for():
    for stream_type in ("vp8", "h264", "ros_compressed", "mjpeg"):
        asked = {"topic": "x", "type": stream_type, "width": "10"}
        assert query.parse_snapshot(asked, 4096).variant == Variant(width=10)


def test_the_raw_topic_is_taken_only_when_it_is_asked_for():
    assert not query.parse_stream({"topic": "x"}, 4096).raw
    assert not query.parse_stream({"topic": "x", "default_transport": "compressed"}, 4096).raw
    asked = {"topic": "x", "default_transport": "raw"}
    assert query.parse_stream(asked, 4096).raw
    # This type is the compressed topic.
    assert not query.parse_stream({**asked, "type": "ros_compressed"}, 4096).raw


@pytest.mark.parametrize(
    ("asked", "status", "said"),
    [
        ({}, 400, "The parameter 'topic' is missing"),
        ({"topic": ""}, 400, "The parameter 'topic' is missing"),
        ({"topic": "x", "type": "vp8"}, 404, "There is no stream type 'vp8'"),
        ({"topic": "x", "width": "wide"}, 400, "The parameter 'width' is 'wide'; it must be"),
        ({"topic": "x", "width": "1e3"}, 400, "The parameter 'width' is '1e3'"),
        ({"topic": "x", "width": ""}, 400, "The parameter 'width' is ''"),
        ({"topic": "x", "width": "-2"}, 400, "The parameter 'width' is -2"),
        ({"topic": "x", "width": "1_0"}, 400, "The parameter 'width' is '1_0'"),
        ({"topic": "x", "height": "5000"}, 400, "The parameter 'height' is 5000; it must be"),
        ({"topic": "x", "height": "9" * 5000}, 400, "The parameter 'height'"),
        ({"topic": "x", "quality": "0"}, 400, "The parameter 'quality' is 0; it must be"),
        ({"topic": "x", "quality": "101"}, 400, "The parameter 'quality' is 101"),
        ({"topic": "x", "quality": "²"}, 400, "The parameter 'quality' is '²'"),
        (
            {"topic": "x", "type": "png", "quality": "10"},
            400,
            "The parameter 'quality' is 10; it must be an integer from 0 (fast) to 9",
        ),
        (
            {"topic": "x", "default_transport": "theora"},
            400,
            "The parameter 'default_transport' is 'theora'; it must be raw or compressed.",
        ),
    ],
)
def test_bad_queries_are_refused_with_a_sentence(asked, status, said):
    with pytest.raises(query.QueryError) as error:
        query.parse_stream(asked, 4096)
    assert error.value.status == status
    assert str(error.value).startswith(said)


# Framing, as web_video_server does it


def test_the_head_of_a_stream():
    lines = mjpeg.STREAM_HEAD.decode().split("\r\n")
    assert lines == [
        "HTTP/1.0 200 OK",
        "Connection: close",
        "Server: web_video_server",
        "Cache-Control: no-cache, no-store, must-revalidate, pre-check=0, post-check=0, max-age=0",
        "Pragma: no-cache",
        "Content-type: multipart/x-mixed-replace;boundary=boundarydonotcross",
        "Access-Control-Allow-Origin: *",
        "Access-Control-Allow-Methods: GET,POST,PUT,DELETE,HEAD,OPTIONS",
        "Access-Control-Allow-Headers: Origin, Authorization, Accept, Content-Type",
        "Access-Control-Max-Age: 3600",
        "",
        "--boundarydonotcross",
        "",
    ]


def test_a_part_of_a_stream():
    head, _, rest = mjpeg.part(b"\xff\xd8data", 12.3456789, "image/jpeg").partition(b"\r\n\r\n")
    assert head.decode().split("\r\n") == [
        "Content-type: image/jpeg",
        "X-Timestamp: 12.345679",
        "Access-Control-Allow-Origin: *",
        "Access-Control-Allow-Methods: GET,POST,PUT,DELETE,HEAD,OPTIONS",
        "Access-Control-Allow-Headers: Origin, Authorization, Accept, Content-Type",
        "Access-Control-Max-Age: 3600",
        "Content-Length: 6",
    ]
    assert rest == b"\xff\xd8data\r\n--boundarydonotcross\r\n"


# Topics

TOPICS = {
    "/telex/cameras/front/image_raw": "sensor_msgs/Image",
    "/telex/cameras/front/image_raw/compressed": "sensor_msgs/CompressedImage",
    "/telex/cameras/front/camera_info": "sensor_msgs/CameraInfo",
    "/telex/cameras/rear/image_raw/compressed": "sensor_msgs/CompressedImage",
    "/raw": "sensor_msgs/Image",
    "/joint_states": "sensor_msgs/JointState",
}
FRONT = PictureTopic("/telex/cameras/front/image_raw/compressed", compressed=True)


@pytest.mark.parametrize(
    ("name", "found"),
    [
        ("/telex/cameras/front/image_raw", FRONT),
        ("telex/cameras/front/image_raw", FRONT),
        ("cameras/front/image_raw", FRONT),
        ("/telex/cameras/front/image_raw/compressed", FRONT),
        ("raw", PictureTopic("/raw", compressed=False)),
        ("/joint_states", None),
        ("/cameras/front/image_raw", None),
        ("nothing", None),
        ("", None),
    ],
)
def test_topics_are_found_as_clients_spell_them(name, found):
    assert find_topic(name, TOPICS, "/telex/") == found


def test_the_raw_topic_is_found_where_there_is_one():
    front, rear = (f"/telex/cameras/{name}/image_raw" for name in ("front", "rear"))
    assert find_topic(front, TOPICS, "/", raw=True) == PictureTopic(front, compressed=False)
    compressed = PictureTopic(f"{rear}/compressed", compressed=True)
    assert find_topic(rear, TOPICS, "/", raw=True) == compressed


def test_cameras_and_image_topics():
    assert find_cameras(TOPICS, "/telex/") == {
        name: f"/telex/cameras/{name}/image_raw" for name in ("front", "rear")
    }
    assert base_topics(TOPICS) == [
        "/raw",
        "/telex/cameras/front/image_raw",
        "/telex/cameras/rear/image_raw",
    ]


def test_the_index_groups_topics_by_camera():
    page = pages.index_page(base_topics(TOPICS), TOPICS, {})
    camera, rest = page.split("</ul></li></ul>")
    assert "/stream_viewer?topic=/telex/cameras/front/image_raw" in camera
    assert "/snapshot?topic=/raw" in rest
    assert "/stream?topic=/telex/cameras/rear/image_raw" in rest


def test_pages_escape_what_comes_from_outside():
    evil = '"><script>alert(1)</script>'
    for page in (
        pages.viewer_page(evil, {"topic": evil, evil: evil}),
        pages.error_page(404, evil),
        pages.index_page([evil], [f"{evil}/camera_info"], {"token": evil}),
        pages.index_page([f"{evil}/image"], [f"{evil}/camera_info"], {}),
    ):
        assert "<script" not in page
