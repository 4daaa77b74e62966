# geomhw with all it needs; without arguments it runs the job of `make demo`:
#   docker build -t geomhw .
#   docker run --rm -v "$PWD/demo:/out" geomhw
#   docker run --rm -v "$PWD:/work" -w /work geomhw geomhw geodesic lh.surf.gii -o lh.dist.func.gii
FROM python:3.12-slim
# EGL, with which VTK draws without a display.
RUN apt-get update && apt-get install --yes --no-install-recommends libegl1 libgl1 libxrender1 && rm -rf /var/lib/apt/lists/*
WORKDIR /opt/geomhw
COPY pyproject.toml README.md LICENSE ./
COPY geomhw geomhw
COPY cli cli
RUN pip install --no-cache-dir ".[mp4]"
COPY data data
# Compiles the loops once for all containers, and checks that pictures can be drawn.
RUN geomhw geodesic data/creature.obj -o /tmp/creature.vtk --png /tmp/creature.png && rm /tmp/creature.*
CMD ["sh", "-c", "mkdir -p /out && geomhw geodesic data/creature.obj -o /out/creature.vtk --png /out/creature.png"]
