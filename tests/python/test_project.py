"""frame.project(): points in a camera's picture, as OpenCV computes them."""
import lumsdk
import numpy as np
import pytest
from lumsdk._project import project

K = np.array([[1000.0, 0, 960], [0, 1010, 540], [0, 0, 1]])
T = np.array([[0, -1, 0, 0.1], [0, 0, -1, 0.2], [1, 0, 0, 0.3], [0, 0, 0, 1.0]])
SIZE = (1920, 1080)
POINTS = np.array([[10, 0, 0], [20, 5, -1], [6, -3, 1.5], [40, 12, 3], [8, 4, -2.5]])
# cv2.projectPoints() of OpenCV 5.0.0
OF_OPENCV = {
    (): [[969.7087, 559.6117], [718.6207, 599.7044], [1452.0635, 331.5873], [664.7146, 469.8263], [490.1205, 868.5542]],
    (-0.3, 0.1, 0.001, -0.002): [[969.7064, 559.6094], [722.6157, 598.7481], [1412.283, 348.4827], [672.1245, 471.7239],
                                 [529.306, 841.0276]],
    (-0.3, 0.1, 0.001, -0.002, 0.01): [[969.7064, 559.6094], [722.6151, 598.7483], [1412.3965, 348.4346],
                                       [672.1222, 471.7234], [529.1423, 841.1421]],
    (0.2, -0.1, 0.001, 0.002, 0.03, 0.1, 0.02, 0.01): [[969.7109, 559.6146], [717.5759, 600.0558], [1462.5704, 327.6658],
                                                       [662.8892, 469.4417], [482.0198, 875.0051]],
}


@pytest.mark.parametrize("distortion", OF_OPENCV, ids=len)
def test_pixels_are_those_of_opencv(distortion):
    seen = project(POINTS, K, T, distortion or None, SIZE)
    assert np.abs(seen.pixels - OF_OPENCV[distortion]).max() < 1e-3
    assert np.allclose(seen.depth, POINTS[:, 0] + 0.3) and seen.visible.all()


def test_a_frame_is_in_the_order_of_its_points(capture):
    frame = next(iter(lumsdk.open(capture)))
    seen = frame.project(K, T[:3], size=SIZE)
    assert seen.pixels.shape == (len(frame), 2) and seen.depth.shape == seen.visible.shape == (len(frame),)
    some = project(frame.xyz[100:110], K, T, None, SIZE)
    assert np.array_equal(seen.pixels[100:110], some.pixels, equal_nan=True)
    assert 0 < seen.visible.sum() < len(frame)


def test_what_is_not_in_the_picture_is_not_visible():
    turn = np.array([[0, -1, 0, 0], [0, 0, -1, 0], [1, 0, 0, 0]])
    seen = project(np.array([[-5.0, 0, 0], [0.0, 1, 0]]), K, turn, None, None)
    assert not seen.visible.any() and np.isnan(seen.pixels).all() and list(seen.depth) == [-5, 0]
    at = np.array([[10, (960.5 - off) / 100, 0.0] for off in (0.01, -0.01)])  # u is -0.49 and -0.51
    assert list(project(at, K, turn, None, SIZE).visible) == [True, False]
    assert project(at, K, turn, None, None).visible.all()


def test_points_from_far_outside_do_not_fold_back_into_the_picture():
    points = np.array([[1.0, y, 0] for y in np.linspace(0, 5, 501)])
    turn = np.array([[0, -1, 0, 0], [0, 0, -1, 0], [1, 0, 0, 0]])
    seen = project(points, K, turn, (-0.3, 0, 0, 0), (100000, 100000))
    limit = (1 / 0.9) ** 0.5  # where r - 0.3 r^3 is highest
    assert list(seen.visible) == list((points[:, 1] < limit) & (seen.pixels[:, 0] >= -0.5))


@pytest.mark.parametrize("given, text", [
    (dict(K=np.eye(4)), "K has the shape"), (dict(K=np.zeros((3, 3))), "fx and fy above 0"),
    (dict(T=np.eye(3)), "T has the shape"), (dict(T=2 * np.eye(4)), "T are not a rotation"), (dict(T=np.diag([1.0, 1, -1, 1])), "T are not a rotation"),
    (dict(distortion=(1, 2, 3)), "3 numbers"), (dict(size=(0, 5)), "width, height"), (dict(size=5), "width, height"),
    (dict(size="ab"), "use numbers"), (dict(size=(np.nan, 5)), "width, height"), (dict(size=(1, 2, 3)), "width, height"),
    (dict(K="ab"), "K is 'ab'; use numbers"), (dict(distortion="ab"), "use numbers"),
    (dict(T=np.vstack([np.eye(4)[:3], np.full((1, 4), 5)])), r"last row of T is .*; use \[0, 0, 0, 1\]"), (dict(T=np.full((4, 4), np.nan)), "finite"),
])
def test_what_is_not_right_is_refused(given, text):
    with pytest.raises(lumsdk.OptionError, match=text):
        project(POINTS, given.get("K", K), given.get("T", T), given.get("distortion"), given.get("size"))
