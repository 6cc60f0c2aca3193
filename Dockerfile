# The service in a container:
#   docker build -t probebake .
#   docker run -p 127.0.0.1:8080:8080 -v probebake-data:/probebake/data probebake
# nginx stands in front of it (configs/nginx.conf). Without --tokens whoever reaches the port may do
# everything (a line at start warns of it), and there is no encryption: publish the port to 127.0.0.1
# only, or give both. Scenes of your own: -v DIRECTORY:/probebake/configs/scenes:ro. With another
# --drain-seconds give `docker stop` more time than that, too.

FROM debian:12-slim AS build
WORKDIR /source
COPY scripts/install-packages scripts/packages.txt scripts/
RUN scripts/install-packages build
COPY . .
RUN scripts/build release --target probebake

FROM debian:12-slim
WORKDIR /probebake
RUN --mount=type=bind,source=scripts,target=/scripts \
    /scripts/install-packages runtime proxy && \
    rm -rf /var/lib/apt/lists/* && \
    useradd --system --no-create-home probebake && \
    install --directory --owner=probebake data
COPY --from=build /source/build/release/probebake /usr/local/bin/
COPY LICENSE .
COPY configs configs
COPY scripts/serve scripts/
USER probebake
VOLUME ["/probebake/data", "/probebake/configs/scenes"]
EXPOSE 8080
HEALTHCHECK --interval=30s --timeout=5s --start-period=10s \
    CMD ["bash", "-c", "exec 3<>/dev/tcp/127.0.0.1/8080 && printf 'GET /healthz HTTP/1.0\\r\\nHost: localhost\\r\\n\\r\\n' >&3 && head -n 1 <&3 | grep -q ' 200 '"]
# It drains within the 10 s after which docker kills: that would count as a crash of what it bakes.
CMD ["scripts/serve", "--listen", "0.0.0.0:8080", "--expose-without-tokens", "--data", "data", \
     "--drain-seconds", "8"]
