# fascicle with all extras: docker build -t fascicle . && docker run --rm fascicle force kim2021_figure_6 --pressure "2 bar"
FROM python:3.13-slim
COPY . /source
RUN pip install --no-cache-dir "/source[all]" && rm -r /source
# files of the host: docker run --rm -v "$PWD:/data" --user "$(id -u)" fascicle init
RUN useradd --create-home muscle && install --directory --owner=muscle /data
USER muscle
WORKDIR /data
# the explorer: docker run --rm -p 5006:5006 fascicle explore --host 0.0.0.0 --no-show
EXPOSE 5006
ENTRYPOINT ["fascicle"]
CMD ["--help"]
